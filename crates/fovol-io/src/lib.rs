//! Volumes, images, video, sessions and data sets, in and out.
