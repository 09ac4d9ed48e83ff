/*
 * FoVolNet: sparse volume rendering with reconstruction. Version 1 of the C interface.
 *
 * This file is made from the sources in bindings/c/src by cbindgen; bindings/c/README.md says how.
 *
 * Objects. Every fovolnet_..._new makes an object and hands out its handle; fovolnet_..._release gives the handle back.
 * Functions that set something change pending parameters. fovolnet_..._commit checks them and makes them count. A frame uses all
 * objects of its renderer as they are committed when it begins.
 *
 * Results. Functions return FOVOLNET_OK or the kind of an error. fovolnet_last_error has its text. Objects and results are
 * unchanged after an error, unless a function says otherwise.
 *
 * Pointers. A handle is NULL or one that was handed out and not released. Texts end in NUL and are UTF-8. NULL where a function
 * needs something is an error; any other invalid pointer is undefined behaviour, and so is releasing a handle twice. Nothing is kept
 * after a call, except voxels.
 *
 * Texts as results. Functions with `text`, `capacity` and `length` write a text with its NUL, shortened to the capacity, and its
 * whole length in bytes without NUL. Either pointer may be NULL.
 *
 * Structs with a `size`. The caller sets it to the sizeof of the struct, so that later versions can add fields at the end.
 *
 * Threads. All functions may be called from any thread. Setting and committing does not wait for frames; frames of one renderer
 * wait for each other. fovolnet_cancel ends long calls.
 *
 * World. The box of the first volume is centred at 0, and its longest side has the length 1. The axes are those of the grid, or of
 * the patient: +x left, +y up, +z to the front.
 */


#ifndef FOVOLNET_H
#define FOVOLNET_H

#include <stddef.h>
#include <stdint.h>

/**
 * Version of the functions and structs in this header. It grows when a function or a struct changes in a way that old
 * programs cannot bear. New functions, and new fields at the end of structs, leave it alone.
 */
#define FOVOLNET_ABI_VERSION 1

/**
 * A still camera in the world. There the box of the volume is centred at 0, and its longest side is 1.
 */
typedef struct FovolnetCamera FovolnetCamera;

/**
 * A rendered frame, which never changes.
 */
typedef struct FovolnetFrame FovolnetFrame;

/**
 * A directional light. Its share is what the setting "ambient" leaves.
 */
typedef struct FovolnetLight FovolnetLight;

/**
 * Reconstructs the sparse frames of one clip, of any renderer, on the CPU. Networks remember earlier frames.
 */
typedef struct FovolnetReconstructor FovolnetReconstructor;

/**
 * A renderer: settings, and what is shown with them. Frames of one renderer are made one after another, for networks remember
 * earlier ones.
 */
typedef struct FovolnetRenderer FovolnetRenderer;

/**
 * Colours and opacities of values.
 */
typedef struct FovolnetTransferFunction FovolnetTransferFunction;

/**
 * A volume: voxels from a file, from the memory of the caller, or made by the library, and volumes laid over them.
 */
typedef struct FovolnetVolume FovolnetVolume;

/**
 * Result of a call: FOVOLNET_OK, or the kind of the error. fovolnet_last_error has its text.
 */
typedef int32_t FovolnetStatus;

/**
 * How a camera projects.
 */
typedef int32_t FovolnetProjection;

/**
 * Facts about a frame. Times are in milliseconds; 0 for stages that did not run or were not timed apart.
 */
typedef struct FovolnetFrameInfo {
    /**
     * sizeof(FovolnetFrameInfo), set by the caller.
     */
    size_t size;
    /**
     * Number of the frame.
     */
    uint32_t index;
    /**
     * Width in pixels.
     */
    uint32_t width;
    /**
     * Height in pixels.
     */
    uint32_t height;
    /**
     * Width before the frame was enlarged, which the planner of the flags "quality" and "budget" may do. Mask, samples, depth and
     * motion have this size; else it is the width.
     */
    uint32_t marched_width;
    /**
     * Height before the frame was enlarged.
     */
    uint32_t marched_height;
    /**
     * Always 0.
     */
    uint32_t reserved;
    /**
     * Number of marched pixels, repeated ones included.
     */
    uint64_t samples;
    /**
     * Number of pixels that were marched without shadow rays besides.
     */
    uint64_t guide_samples;
    /**
     * Time of choosing pixels, without `compact`.
     */
    double mask_ms;
    /**
     * Time of listing them.
     */
    double compact_ms;
    /**
     * Time of marching, without `scatter`.
     */
    double march_ms;
    /**
     * Time of the way from rays to the sparse frame.
     */
    double scatter_ms;
    /**
     * Time of the pixels without shadow rays.
     */
    double guide_ms;
    /**
     * Time of finding motion.
     */
    double motion_ms;
    /**
     * Time of the reconstruction.
     */
    double fill_ms;
    /**
     * Time of the planner.
     */
    double plan_ms;
    /**
     * Time of the whole frame.
     */
    double total_ms;
} FovolnetFrameInfo;

/**
 * Part of a frame that can be read.
 */
typedef int32_t FovolnetChannel;

/**
 * A sparse frame in the memory of the caller. Fill the struct with zeros first. Pictures have no gaps, rows from top to bottom.
 */
typedef struct FovolnetSparseFrame {
    /**
     * sizeof(FovolnetSparseFrame).
     */
    size_t size;
    /**
     * Width in pixels, that of the reconstructor.
     */
    uint32_t width;
    /**
     * Height in pixels, that of the reconstructor.
     */
    uint32_t height;
    /**
     * Display colours (sRGB), 0 to 1, of all pixels; those that are not sampled do not count.
     */
    const float *colours;
    /**
     * Number of float a pixel in `colours`: 3, or 4 of which the last does not count. 0 means 3.
     */
    uint32_t components;
    /**
     * Always 0.
     */
    uint32_t reserved;
    /**
     * Which pixels are sampled: one byte a pixel, 0 if not.
     */
    const uint8_t *mask;
    /**
     * Way of each pixel to its place in the last frame in pixels, right and down: 2 float a pixel. NULL for a scene that stands
     * still.
     */
    const float *motion;
} FovolnetSparseFrame;

/**
 * Type of voxels.
 */
typedef int32_t FovolnetDtype;

/**
 * Meaning of voxels.
 */
typedef int32_t FovolnetMeaning;

/**
 * Space in which a grid is placed.
 */
typedef int32_t FovolnetSpace;

/**
 * Called once with `user` when the voxels are not needed any more, on the thread that gives the last use of them up. It must not
 * call functions of this library.
 */
typedef void (*FovolnetRelease)(void *user);

/**
 * Voxels in the memory of the caller. Fill the struct with zeros, then set `size`, `data`, `bytes`, `dims`, `spacing` and `dtype`;
 * everything else may stay zero.
 */
typedef struct FovolnetVoxels {
    /**
     * sizeof(FovolnetVoxels).
     */
    size_t size;
    /**
     * The first component of the first voxel. Components of a voxel lie side by side; x is fastest, then y, then z, without gaps.
     * The byte order is that of the processor; any alignment will do. Nobody may write there until `release` is called.
     */
    const void *data;
    /**
     * Number of bytes at `data`: at least the product of dims, components and the size of the type.
     */
    size_t bytes;
    /**
     * Number of voxels along x, y, z.
     */
    uint64_t dims[3];
    /**
     * Distance of voxels along x, y, z, above 0. Pictures depend on their ratios only.
     */
    double spacing[3];
    /**
     * Type of each component.
     */
    FovolnetDtype dtype;
    /**
     * Number of components of each voxel; 0 means 1.
     */
    uint32_t components;
    /**
     * Meaning of the components.
     */
    FovolnetMeaning meaning;
    /**
     * Whether and where the grid is placed by `directions` and `origin`.
     */
    FovolnetSpace space;
    /**
     * Directions of the x, y and z axis of the grid, three numbers each, in LPS: left, posterior, superior. Any length will do.
     */
    double directions[9];
    /**
     * Centre of the first voxel in LPS, in the unit of `spacing`.
     */
    double origin[3];
    /**
     * Name for notes and errors; NULL is "the volume". It is copied.
     */
    const char *name;
    /**
     * Called when the voxels are not needed any more; may be NULL. Without it, keep them until every volume and renderer that was
     * given them is released.
     */
    FovolnetRelease release;
    /**
     * Argument of `release`.
     */
    void *user;
} FovolnetVoxels;

/**
 * Facts about a committed volume.
 */
typedef struct FovolnetVolumeInfo {
    /**
     * sizeof(FovolnetVolumeInfo), set by the caller.
     */
    size_t size;
    /**
     * Number of voxels along x, y, z.
     */
    uint64_t dims[3];
    /**
     * Distance of voxels along x, y, z.
     */
    double spacing[3];
    /**
     * Values shown as 0 and 1 of a transfer function.
     */
    double range[2];
    /**
     * Smallest and largest finite value.
     */
    double extremes[2];
    /**
     * Type of the voxels.
     */
    FovolnetDtype dtype;
    /**
     * Number of components of each voxel.
     */
    uint32_t components;
    /**
     * Number of volumes and channels that are shown together, this one included.
     */
    uint32_t layers;
    /**
     * Whether the position in space is known: 0 or 1.
     */
    uint32_t is_placed;
} FovolnetVolumeInfo;

/**
 * Rays from the eye.
 */
#define FOVOLNET_PERSPECTIVE 0

/**
 * Parallel rays. The picture is as high as the field of view at the target.
 */
#define FOVOLNET_ORTHOGRAPHIC 1

/**
 * The picture: 4 uint8_t a pixel. Display colours (sRGB) and opacity, not premultiplied; opacity is 255 unless the flag
 * "transparent" is set, or pixels stay empty for lack of a reconstruction.
 */
#define FOVOLNET_RGBA8 1

/**
 * The picture: 3 uint8_t a pixel. Display colours (sRGB).
 */
#define FOVOLNET_RGB8 2

/**
 * The picture: 4 float a pixel. Display colours (sRGB), 0 to 1, and opacity, not premultiplied.
 */
#define FOVOLNET_RGBA32F 3

/**
 * Colours of the marched pixels: 4 float a pixel. The last is 1 where a pixel was marched; all are 0 elsewhere.
 */
#define FOVOLNET_SPARSE_RGBA32F 4

/**
 * Which pixels were marched: 1 uint8_t a pixel, 1 or 0.
 */
#define FOVOLNET_MASK8 5

/**
 * Distances of marched pixels from the eye in world units: 1 float a pixel. Infinite where nothing shows and where no pixel was
 * marched. Frames of sampling "full" have none; sampling "compact" with pb 1 and reconstruct "none" marches every pixel and has it.
 */
#define FOVOLNET_DEPTH32F 6

/**
 * Way of each pixel to its place in the last frame in pixels, right and down: 2 float a pixel. The first frame has none. Later ones
 * have it if a network uses it, or after fovolnet_renderer_find_motion.
 */
#define FOVOLNET_MOTION32F 7

/**
 * List of marched pixels in raster order: 2 uint16_t each, column and row. Frames of sampling "full" have no lists.
 */
#define FOVOLNET_SAMPLE_PIXELS16 8

/**
 * Colours of the listed pixels: 3 float each.
 */
#define FOVOLNET_SAMPLE_RGB32F 9

/**
 * Distances of the listed pixels from the eye: 1 float each.
 */
#define FOVOLNET_SAMPLE_DEPTH32F 10

/**
 * Success.
 */
#define FOVOLNET_OK 0

/**
 * A null pointer, a wrong size, an unknown name, a setting that cannot be used, or too little memory.
 */
#define FOVOLNET_ERROR_INVALID 1

/**
 * A file that is missing, unreadable or broken.
 */
#define FOVOLNET_ERROR_FILE 2

/**
 * The graphics processor failed. The CPU may still work: set "device" to "cpu".
 */
#define FOVOLNET_ERROR_GPU 3

/**
 * fovolnet_cancel ended the call.
 */
#define FOVOLNET_CANCELLED 4

/**
 * The frame has no such channel.
 */
#define FOVOLNET_ABSENT 5

/**
 * A fault of the library. Please report it.
 */
#define FOVOLNET_ERROR_INTERNAL 6

/**
 * uint8_t
 */
#define FOVOLNET_U8 1

/**
 * int8_t
 */
#define FOVOLNET_I8 2

/**
 * uint16_t
 */
#define FOVOLNET_U16 3

/**
 * int16_t
 */
#define FOVOLNET_I16 4

/**
 * uint32_t
 */
#define FOVOLNET_U32 5

/**
 * int32_t
 */
#define FOVOLNET_I32 6

/**
 * uint64_t
 */
#define FOVOLNET_U64 7

/**
 * int64_t
 */
#define FOVOLNET_I64 8

/**
 * Half precision of IEEE 754
 */
#define FOVOLNET_F16 9

/**
 * float
 */
#define FOVOLNET_F32 10

/**
 * double
 */
#define FOVOLNET_F64 11

/**
 * Values, of which the first component is shown.
 */
#define FOVOLNET_VALUES 0

/**
 * Three or four components: red, green, blue, and opacity. Without a fourth, luminance is the opacity.
 */
#define FOVOLNET_COLOURS 1

/**
 * Labels, between which nothing is interpolated.
 */
#define FOVOLNET_LABELS 2

/**
 * None: the grid stands along x, y and z of the world.
 */
#define FOVOLNET_SPACE_NONE 0

/**
 * Patient space. Pictures show the patient upright, as "orientation" says.
 */
#define FOVOLNET_SPACE_PATIENT 1

/**
 * Other space, which aligns volumes with each other.
 */
#define FOVOLNET_SPACE_OTHER 2

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Text of the last failed call of this thread: one line in UTF-8 that says what is wrong and how to mend it. Empty if no call
 * has failed. The text holds until the next failed call of this thread.
 */
const char *fovolnet_last_error(void);

/**
 * Makes a camera at 0, 0, 3 that looks at 0, with +y up and 35 degrees. Give the handle to fovolnet_camera_release in the end.
 */
FovolnetStatus fovolnet_camera_new(struct FovolnetCamera **camera);

/**
 * Gives the handle back. NULL is fine; a handle that was released must not be used again.
 */
void fovolnet_camera_release(struct FovolnetCamera *camera);

/**
 * Sets the position of the eye, the point in the middle of the picture, and the direction that is up in it: three numbers each.
 * `up` may be NULL for +y.
 */
FovolnetStatus fovolnet_camera_look_at(struct FovolnetCamera *camera,
                                       const double *eye,
                                       const double *target,
                                       const double *up);

/**
 * Sets the vertical field of view in degrees, above 0 and below 180.
 */
FovolnetStatus fovolnet_camera_set_fovy(struct FovolnetCamera *camera, double degrees);

/**
 * Sets how the camera projects: FOVOLNET_PERSPECTIVE or FOVOLNET_ORTHOGRAPHIC.
 */
FovolnetStatus fovolnet_camera_set_projection(struct FovolnetCamera *camera, FovolnetProjection projection);

/**
 * Checks the pending parameters. Renderers use them from their next frame on.
 */
FovolnetStatus fovolnet_camera_commit(struct FovolnetCamera *camera);

/**
 * Ends all calls that are at work in this moment, on any thread: they return FOVOLNET_CANCELLED within milliseconds. Calls that
 * begin later wait until those have ended, and then do their work. Objects stay usable; a renderer that was cancelled prepares
 * its volume again, and a network forgets earlier frames. Does nothing if no call is at work. Any thread may call it, but no
 * signal handler may.
 */
void fovolnet_cancel(void);

/**
 * Gives the handle back. NULL is fine; a handle that was released must not be used again.
 */
void fovolnet_frame_release(struct FovolnetFrame *frame);

/**
 * Writes facts about the frame to `info`, whose `size` the caller has set.
 */
FovolnetStatus fovolnet_frame_info(const struct FovolnetFrame *frame, struct FovolnetFrameInfo *info);

/**
 * Writes the number of bytes of a channel to `bytes`. FOVOLNET_ABSENT if the frame does not have it.
 */
FovolnetStatus fovolnet_frame_bytes(const struct FovolnetFrame *frame,
                                    FovolnetChannel channel,
                                    size_t *bytes);

/**
 * Copies a channel to `buffer`, which has `bytes` bytes. Rows come from top to bottom, `pitch` bytes from one to the next; 0 for
 * rows without gaps. A negative pitch puts the bottom row first, as OpenGL and ANARI have it. Lists have no rows: their pitch is 0.
 */
FovolnetStatus fovolnet_frame_read(const struct FovolnetFrame *frame,
                                   FovolnetChannel channel,
                                   void *buffer,
                                   size_t bytes,
                                   ptrdiff_t pitch);

/**
 * Makes a light from the usual direction. Give the handle to fovolnet_light_release in the end.
 */
FovolnetStatus fovolnet_light_new(struct FovolnetLight **light);

/**
 * Gives the handle back. NULL is fine; a handle that was released must not be used again.
 */
void fovolnet_light_release(struct FovolnetLight *light);

/**
 * Sets the direction from the scene towards the light: three numbers, of any length, in the world of the camera.
 */
FovolnetStatus fovolnet_light_set_towards(struct FovolnetLight *light,
                                          const double *direction);

/**
 * Checks the pending direction. Renderers use it from their next frame on.
 */
FovolnetStatus fovolnet_light_commit(struct FovolnetLight *light);

/**
 * Makes a reconstructor of frames of `width` by `height` pixels. `json` is NULL, or an object with the flags "reconstruct", "weights",
 * "random-weights" and "precision"; by default it is the network wnet-fast. Give the handle to fovolnet_reconstructor_release in
 * the end.
 */
FovolnetStatus fovolnet_reconstructor_new(uint32_t width,
                                          uint32_t height,
                                          const char *json,
                                          struct FovolnetReconstructor **reconstructor);

/**
 * Gives the handle back. NULL is fine; a handle that was released must not be used again.
 */
void fovolnet_reconstructor_release(struct FovolnetReconstructor *reconstructor);

/**
 * Reconstructs the next frame of the clip and writes it to `picture`: 4 float a pixel, display colours 0 to 1 and opacity 1.
 * `bytes` is the size of `picture`. fovolnet_cancel ends it; earlier frames are forgotten then.
 */
FovolnetStatus fovolnet_reconstructor_reconstruct(struct FovolnetReconstructor *reconstructor,
                                                  const struct FovolnetSparseFrame *sparse,
                                                  float *picture,
                                                  size_t bytes);

/**
 * Forgets earlier frames, as after a cut.
 */
FovolnetStatus fovolnet_reconstructor_reset(struct FovolnetReconstructor *reconstructor);

/**
 * Writes whether the reconstructor uses motion, 0 or 1, to `uses_motion`.
 */
FovolnetStatus fovolnet_reconstructor_uses_motion(const struct FovolnetReconstructor *reconstructor,
                                                  uint32_t *uses_motion);

/**
 * Makes a renderer with the defaults of the command line. Give the handle to fovolnet_renderer_release in the end.
 */
FovolnetStatus fovolnet_renderer_new(struct FovolnetRenderer **renderer);

/**
 * Gives the handle back. NULL is fine; a handle that was released must not be used again. Frames of the renderer stay.
 */
void fovolnet_renderer_release(struct FovolnetRenderer *renderer);

/**
 * Sets a flag of the command line by its name and its value, such as "shadow-rays" and "16", or "clip" and "0,0.5,0,1,0,1".
 * `fovolnet render --help` lists all of them: those of pictures, and of speed "device", "threads", "filtering" and "no-skip".
 * Flags without a value take "true" and "false". A flag that may be given several times is set once; fovolnet_renderer_set_json
 * takes lists.
 */
FovolnetStatus fovolnet_renderer_set(struct FovolnetRenderer *renderer,
                                     const char *name,
                                     const char *value);

/**
 * Sets all flags in a JSON object, such as {"size": [640, 480], "shadows": "off", "step": 0.5}. Texts are read as the command line
 * reads them. Null takes a flag back. An error changes nothing.
 */
FovolnetStatus fovolnet_renderer_set_json(struct FovolnetRenderer *renderer,
                                          const char *json);

/**
 * Takes a flag back, so that its default holds.
 */
FovolnetStatus fovolnet_renderer_unset(struct FovolnetRenderer *renderer, const char *name);

/**
 * Writes the flags that are set, as a JSON object. Texts: see the top of the header.
 */
FovolnetStatus fovolnet_renderer_settings(const struct FovolnetRenderer *renderer,
                                          char *text,
                                          size_t capacity,
                                          size_t *length);

/**
 * Sets width and height of frames in pixels, 1 to 32768 each. It is the flag "size".
 */
FovolnetStatus fovolnet_renderer_set_size(struct FovolnetRenderer *renderer, uint32_t width, uint32_t height);

/**
 * Sets the volume to show; NULL for none. The renderer keeps it, so its handle may be released.
 */
FovolnetStatus fovolnet_renderer_set_volume(struct FovolnetRenderer *renderer,
                                            const struct FovolnetVolume *volume);

/**
 * Sets the transfer function; NULL for that of the flag "tf". The renderer keeps it, so its handle may be released.
 */
FovolnetStatus fovolnet_renderer_set_transfer_function(struct FovolnetRenderer *renderer,
                                                       const struct FovolnetTransferFunction *transfer_function);

/**
 * Sets the camera; NULL for that of the flags "camera", "path", "view", "turn" and "projection". The renderer keeps it, so its
 * handle may be released.
 */
FovolnetStatus fovolnet_renderer_set_camera(struct FovolnetRenderer *renderer,
                                            const struct FovolnetCamera *camera);

/**
 * Sets the light; NULL for that of the flag "light". The renderer keeps it, so its handle may be released.
 */
FovolnetStatus fovolnet_renderer_set_light(struct FovolnetRenderer *renderer,
                                           const struct FovolnetLight *light);

/**
 * Sets whether sparse frames have motion even if no network uses it: 0 or 1. Frames with every pixel marched never have it.
 */
FovolnetStatus fovolnet_renderer_find_motion(struct FovolnetRenderer *renderer,
                                             uint32_t finds_motion);

/**
 * Checks the pending flags, and uses them from the next frame on. Files of paths and gaze are read here. After an error the flags of
 * the last commit stay.
 */
FovolnetStatus fovolnet_renderer_commit(struct FovolnetRenderer *renderer);

/**
 * Renders frame `i` with all objects as they are committed now. Noise, paths and gaze follow `i`; networks take the frame for the
 * successor of the last one. The first frame prepares the volume. Give `frame` to fovolnet_frame_release in the end. May take
 * long; fovolnet_cancel ends it.
 */
FovolnetStatus fovolnet_renderer_render(struct FovolnetRenderer *renderer,
                                        uint32_t i,
                                        struct FovolnetFrame **frame);

/**
 * Renders frame `i` with every pixel marched and exact shadows, to compare with. Networks do not notice it. Give `frame` to
 * fovolnet_frame_release in the end. May take long; fovolnet_cancel ends it.
 */
FovolnetStatus fovolnet_renderer_reference(struct FovolnetRenderer *renderer,
                                           uint32_t i,
                                           struct FovolnetFrame **frame);

/**
 * Forgets earlier frames, as after a cut.
 */
FovolnetStatus fovolnet_renderer_reset(struct FovolnetRenderer *renderer);

/**
 * Writes the camera of frame `i` as numbers: eye, target and up, three each, and the vertical field of view in degrees. Any of the
 * four may be NULL. Prepares the volume if no frame has done so.
 */
FovolnetStatus fovolnet_renderer_camera(struct FovolnetRenderer *renderer,
                                        uint32_t i,
                                        double *eye,
                                        double *target,
                                        double *up,
                                        double *fovy);

/**
 * Writes what was assumed or replaced for the frames: one line each. Prepares the volume if no frame has done so. Texts: see the top
 * of the header.
 */
FovolnetStatus fovolnet_renderer_notes(struct FovolnetRenderer *renderer,
                                       char *text,
                                       size_t capacity,
                                       size_t *length);

/**
 * Writes the name of the graphics processor that renders; an empty text where the processor does. Prepares the volume if no frame
 * has done so. Texts: see the top of the header.
 */
FovolnetStatus fovolnet_renderer_gpu(struct FovolnetRenderer *renderer,
                                     char *text,
                                     size_t capacity,
                                     size_t *length);

/**
 * Makes a transfer function, which follows the histogram until it is set. Give the handle to fovolnet_transfer_function_release in
 * the end.
 */
FovolnetStatus fovolnet_transfer_function_new(struct FovolnetTransferFunction **transfer_function);

/**
 * Gives the handle back. NULL is fine; a handle that was released must not be used again.
 */
void fovolnet_transfer_function_release(struct FovolnetTransferFunction *transfer_function);

/**
 * Sets the value of the flag "tf": "auto", the name of a preset or a colour map such as "viridis", a file, or JSON such as
 * {"points": [[0, 0, 0, 0, 0], [1, 1, 1, 1, 0.5]]}. Control points of earlier calls are forgotten.
 */
FovolnetStatus fovolnet_transfer_function_set(struct FovolnetTransferFunction *transfer_function,
                                              const char *value);

/**
 * Sets `count` control points of five numbers each, between which colours are linear: value, red, green, blue, opacity of one
 * voxel. All are 0 to 1, and values rise. Value 0 and 1 are the ends of the range that the volume shows, or of
 * fovolnet_transfer_function_set_range. Colours are display colours (sRGB). The numbers are copied.
 */
FovolnetStatus fovolnet_transfer_function_set_points(struct FovolnetTransferFunction *transfer_function,
                                                     const double *points,
                                                     size_t count);

/**
 * Sets the values of the data at which control points 0 and 1 lie. Two equal numbers take the range back: control points then span
 * the range that the volume shows.
 */
FovolnetStatus fovolnet_transfer_function_set_range(struct FovolnetTransferFunction *transfer_function,
                                                    double low,
                                                    double high);

/**
 * Sets factors of opacity by the length of the gradient: `count` points of two numbers each, the length in values of the transfer
 * function a voxel, and the factor 0 to 1. No points take it back. The numbers are copied.
 */
FovolnetStatus fovolnet_transfer_function_set_gradient(struct FovolnetTransferFunction *transfer_function,
                                                       const double *points,
                                                       size_t count);

/**
 * Checks the pending parameters. Renderers use them from their next frame on. Files are read then, not now.
 */
FovolnetStatus fovolnet_transfer_function_commit(struct FovolnetTransferFunction *transfer_function);

/**
 * Version of the library that is linked. A program whose FOVOLNET_ABI_VERSION is another must not go on.
 */
uint32_t fovolnet_abi_version(void);

/**
 * Release of the library, such as "0.1.0". The text is never freed.
 */
const char *fovolnet_version(void);

/**
 * Makes a volume without voxels. Give the handle to fovolnet_volume_release in the end.
 */
FovolnetStatus fovolnet_volume_new(struct FovolnetVolume **volume);

/**
 * Gives the handle back. NULL is fine; a handle that was released must not be used again. Renderers that show the volume keep what
 * they need.
 */
void fovolnet_volume_release(struct FovolnetVolume *volume);

/**
 * Sets where the voxels come from: a file, a folder of slices, an address of Zarr on the web, or the name of a procedural volume
 * such as "head". Paths may hold any bytes. The next commit opens it.
 */
FovolnetStatus fovolnet_volume_set_source(struct FovolnetVolume *volume,
                                          const char *source);

/**
 * Sets voxels in the memory of the caller, which are not copied. The struct itself may go away after the call. After an error the
 * library does not know the voxels, and never calls `release`.
 */
FovolnetStatus fovolnet_volume_set_voxels(struct FovolnetVolume *volume,
                                          const struct FovolnetVoxels *voxels);

/**
 * Sets how the volume is read, by the name and the value of a flag of the command line: "dims", "dtype", "endian", "spacing",
 * "range", "window", "array", "component", "channel", "time", "level", "series", "overlay", "downsample". Voxels in memory take
 * spacing, range, window, component and downsample.
 */
FovolnetStatus fovolnet_volume_set(struct FovolnetVolume *volume,
                                   const char *name,
                                   const char *value);

/**
 * Sets all settings in a JSON object, such as {"dims": [64, 64, 32], "dtype": "u8"}. Null takes a setting back. An error changes
 * nothing.
 */
FovolnetStatus fovolnet_volume_set_json(struct FovolnetVolume *volume,
                                        const char *json);

/**
 * Takes a setting back, so that its default holds.
 */
FovolnetStatus fovolnet_volume_unset(struct FovolnetVolume *volume, const char *name);

/**
 * Lays `overlay` over the box of `volume` at the next commit, up to three times. Positions align the two; without them the overlay
 * is stretched to the box. `transfer_function` may be NULL for colours of the library's choice. Both must be committed before
 * `volume` is, and a later commit of theirs is seen after another commit of `volume`.
 */
FovolnetStatus fovolnet_volume_add_overlay(struct FovolnetVolume *volume,
                                           const struct FovolnetVolume *overlay,
                                           const struct FovolnetTransferFunction *transfer_function);

/**
 * Takes all overlays of fovolnet_volume_add_overlay back.
 */
FovolnetStatus fovolnet_volume_clear_overlays(struct FovolnetVolume *volume);

/**
 * Opens the volume with its pending parameters. Renderers show it from their next frame on. After an error the volume of the last
 * commit stays. May take long; fovolnet_cancel ends it.
 */
FovolnetStatus fovolnet_volume_commit(struct FovolnetVolume *volume);

/**
 * Writes facts about the committed volume to `info`, whose `size` the caller has set.
 */
FovolnetStatus fovolnet_volume_info(const struct FovolnetVolume *volume, struct FovolnetVolumeInfo *info);

/**
 * Writes what was assumed while the committed volume was read, and why little of it may be visible: one line each. Texts: see the
 * top of the header.
 */
FovolnetStatus fovolnet_volume_notes(const struct FovolnetVolume *volume,
                                     char *text,
                                     size_t capacity,
                                     size_t *length);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* FOVOLNET_H */
