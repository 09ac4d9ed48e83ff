//! What a clip is judged by.
