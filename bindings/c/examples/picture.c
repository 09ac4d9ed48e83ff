/* Renders a volume to a PPM picture:
 *
 *     picture head head.ppm
 *     picture scan.nii.gz scan.ppm size=640x480 tf=bone shadows=off
 */
#include <fovolnet.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Says the last error and returns 0 if a call has failed. */
static int worked(FovolnetStatus status)
{
    if (status == FOVOLNET_OK) {
        return 1;
    }
    fprintf(stderr, "error: %s\n", fovolnet_last_error());
    return 0;
}

/* Sets NAME=VALUE. */
static int set(FovolnetRenderer *renderer, const char *setting)
{
    char name[64];
    const char *value = strchr(setting, '=');
    if (value == NULL || (size_t)(value - setting) >= sizeof name) {
        fprintf(stderr, "error: `%s` is no setting; write NAME=VALUE, as in step=0.5\n", setting);
        return 0;
    }
    memcpy(name, setting, (size_t)(value - setting));
    name[value - setting] = '\0';
    return worked(fovolnet_renderer_set(renderer, name, value + 1));
}

/* Opens the volume and prints what was assumed. */
static int open_volume(FovolnetVolume **volume, const char *source)
{
    char notes[1024];
    if (!worked(fovolnet_volume_new(volume)) || !worked(fovolnet_volume_set_source(*volume, source)) ||
        !worked(fovolnet_volume_commit(*volume)) ||
        !worked(fovolnet_volume_notes(*volume, notes, sizeof notes, NULL))) {
        return 0;
    }
    if (notes[0] != '\0') {
        printf("%s\n", notes);
    }
    return 1;
}

/* Makes the renderer with all settings. */
static int open_renderer(FovolnetRenderer **renderer, const FovolnetVolume *volume, int count, char **settings)
{
    int i;
    if (!worked(fovolnet_renderer_new(renderer)) || !worked(fovolnet_renderer_set_volume(*renderer, volume))) {
        return 0;
    }
    for (i = 0; i < count; i++) {
        if (!set(*renderer, settings[i])) {
            return 0;
        }
    }
    return worked(fovolnet_renderer_commit(*renderer));
}

/* Writes the frame to a file. */
static int write_picture(const FovolnetFrame *frame, const char *path)
{
    FovolnetFrameInfo info;
    unsigned char *pixels;
    size_t bytes;
    FILE *file = NULL;
    int is_written;
    memset(&info, 0, sizeof info);
    info.size = sizeof info;
    if (!worked(fovolnet_frame_info(frame, &info)) || !worked(fovolnet_frame_bytes(frame, FOVOLNET_RGB8, &bytes))) {
        return 0;
    }
    pixels = malloc(bytes);
    is_written = pixels != NULL && worked(fovolnet_frame_read(frame, FOVOLNET_RGB8, pixels, bytes, 0)) &&
                 (file = fopen(path, "wb")) != NULL &&
                 fprintf(file, "P6\n%u %u\n255\n", (unsigned)info.width, (unsigned)info.height) > 0 &&
                 fwrite(pixels, 1, bytes, file) == bytes;
    if (file != NULL && fclose(file) != 0) {
        is_written = 0;
    }
    free(pixels);
    if (is_written) {
        printf("%s: %ux%u in %.1f ms\n", path, (unsigned)info.width, (unsigned)info.height, info.total_ms);
    } else {
        fprintf(stderr, "error: cannot write %s; check the path\n", path);
    }
    return is_written;
}

int main(int count, char **arguments)
{
    FovolnetVolume *volume = NULL;
    FovolnetRenderer *renderer = NULL;
    FovolnetFrame *frame = NULL;
    int is_done;
    if (count < 3) {
        fprintf(stderr, "usage: picture VOLUME PICTURE.ppm [NAME=VALUE]...\n");
        return 2;
    }
    if (fovolnet_abi_version() != FOVOLNET_ABI_VERSION) {
        fprintf(stderr, "error: the library has another ABI than its header; build this program again\n");
        return 1;
    }
    is_done = open_volume(&volume, arguments[1]) &&
              open_renderer(&renderer, volume, count - 3, arguments + 3) &&
              worked(fovolnet_renderer_render(renderer, 0, &frame)) && write_picture(frame, arguments[2]);
    fovolnet_frame_release(frame);
    fovolnet_renderer_release(renderer);
    fovolnet_volume_release(volume);
    return is_done ? 0 : 1;
}
