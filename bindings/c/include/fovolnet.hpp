// FoVolNet for C++17: handles that release themselves, and errors as exceptions. fovolnet.h documents the functions.
#ifndef FOVOLNET_HPP
#define FOVOLNET_HPP

#include "fovolnet.h"

#include <array>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace fovolnet {

/// A failed call. `what` is one line that says what is wrong and how to mend it.
class Error : public std::runtime_error {
public:
    explicit Error(FovolnetStatus status) : std::runtime_error(fovolnet_last_error()), status_(status) {}

    /// The kind of the error: FOVOLNET_ERROR_FILE, FOVOLNET_CANCELLED and others.
    FovolnetStatus status() const noexcept { return status_; }

private:
    FovolnetStatus status_;
};

/// Throws unless `status` is FOVOLNET_OK.
inline void check(FovolnetStatus status) {
    if (status != FOVOLNET_OK) {
        throw Error(status);
    }
}

/// Throws if the linked library is not the one that this header belongs to.
inline void check_abi() {
    if (fovolnet_abi_version() != FOVOLNET_ABI_VERSION) {
        throw std::runtime_error("the FoVolNet library has another ABI than its header; build the program again");
    }
}

namespace detail {

/// Handle that is released at the end of its life.
template <typename T, void (*release)(T *)>
class Handle {
public:
    T *get() const noexcept { return handle_.get(); }

protected:
    Handle() : handle_(nullptr, release) {}
    explicit Handle(T *handle) : handle_(handle, release) {}

    template <typename Make>
    void make(Make make) {
        T *made = nullptr;
        check(make(&made));
        handle_.reset(made);
    }

private:
    std::unique_ptr<T, void (*)(T *)> handle_;
};

/// Text that `write` writes to a buffer.
template <typename Write>
std::string text(Write write) {
    std::size_t length = 0;
    check(write(nullptr, 0, &length));
    std::string text(length + 1, '\0');
    check(write(&text[0], text.size(), nullptr));
    text.resize(length);
    return text;
}

} // namespace detail

using Vector = std::array<double, 3>;

class TransferFunction : public detail::Handle<FovolnetTransferFunction, fovolnet_transfer_function_release> {
public:
    TransferFunction() { make(fovolnet_transfer_function_new); }
    /// A preset, a colour map, a file or JSON; committed.
    explicit TransferFunction(const std::string &value) : TransferFunction() {
        check(fovolnet_transfer_function_set(get(), value.c_str()));
        commit();
    }
    /// Control points: value, red, green, blue, opacity.
    void set_points(const std::vector<std::array<double, 5>> &points) {
        check(fovolnet_transfer_function_set_points(get(), points.empty() ? nullptr : points[0].data(), points.size()));
    }
    void set_range(double low, double high) { check(fovolnet_transfer_function_set_range(get(), low, high)); }
    void commit() { check(fovolnet_transfer_function_commit(get())); }
};

class Volume : public detail::Handle<FovolnetVolume, fovolnet_volume_release> {
public:
    Volume() { make(fovolnet_volume_new); }
    /// A file, a folder, an address or the name of a procedural volume. It is not committed yet.
    explicit Volume(const std::string &source) : Volume() {
        check(fovolnet_volume_set_source(get(), source.c_str()));
    }
    /// Voxels in memory, without a copy. They are not committed yet.
    explicit Volume(const FovolnetVoxels &voxels) : Volume() { check(fovolnet_volume_set_voxels(get(), &voxels)); }
    Volume &set(const std::string &name, const std::string &value) {
        check(fovolnet_volume_set(get(), name.c_str(), value.c_str()));
        return *this;
    }
    void add_overlay(const Volume &overlay, const TransferFunction *function = nullptr) {
        check(fovolnet_volume_add_overlay(get(), overlay.get(), function ? function->get() : nullptr));
    }
    void commit() { check(fovolnet_volume_commit(get())); }
    FovolnetVolumeInfo info() const {
        FovolnetVolumeInfo info{};
        info.size = sizeof info;
        check(fovolnet_volume_info(get(), &info));
        return info;
    }
    std::string notes() const {
        return detail::text([this](char *text, std::size_t capacity, std::size_t *length) {
            return fovolnet_volume_notes(get(), text, capacity, length);
        });
    }
};

class Camera : public detail::Handle<FovolnetCamera, fovolnet_camera_release> {
public:
    Camera() { make(fovolnet_camera_new); }
    void look_at(const Vector &eye, const Vector &target, const Vector &up = {0.0, 1.0, 0.0}) {
        check(fovolnet_camera_look_at(get(), eye.data(), target.data(), up.data()));
    }
    void set_fovy(double degrees) { check(fovolnet_camera_set_fovy(get(), degrees)); }
    void set_projection(FovolnetProjection projection) { check(fovolnet_camera_set_projection(get(), projection)); }
    void commit() { check(fovolnet_camera_commit(get())); }
};

class Light : public detail::Handle<FovolnetLight, fovolnet_light_release> {
public:
    Light() { make(fovolnet_light_new); }
    /// A light in this direction from the scene; committed.
    explicit Light(const Vector &towards) : Light() {
        set_towards(towards);
        commit();
    }
    void set_towards(const Vector &direction) { check(fovolnet_light_set_towards(get(), direction.data())); }
    void commit() { check(fovolnet_light_commit(get())); }
};

class Frame : public detail::Handle<FovolnetFrame, fovolnet_frame_release> {
public:
    explicit Frame(FovolnetFrame *frame) : Handle(frame) {}
    FovolnetFrameInfo info() const {
        FovolnetFrameInfo info{};
        info.size = sizeof info;
        check(fovolnet_frame_info(get(), &info));
        return info;
    }
    /// A channel as values of type T, such as float for FOVOLNET_RGBA32F.
    template <typename T = std::uint8_t>
    std::vector<T> read(FovolnetChannel channel) const {
        std::size_t bytes = 0;
        check(fovolnet_frame_bytes(get(), channel, &bytes));
        std::vector<T> values(bytes / sizeof(T));
        check(fovolnet_frame_read(get(), channel, values.data(), values.size() * sizeof(T), 0));
        return values;
    }
};

class Renderer : public detail::Handle<FovolnetRenderer, fovolnet_renderer_release> {
public:
    Renderer() { make(fovolnet_renderer_new); }
    explicit Renderer(const Volume &volume) : Renderer() { set_volume(volume); }
    Renderer &set(const std::string &name, const std::string &value) {
        check(fovolnet_renderer_set(get(), name.c_str(), value.c_str()));
        return *this;
    }
    Renderer &set_json(const std::string &json) {
        check(fovolnet_renderer_set_json(get(), json.c_str()));
        return *this;
    }
    Renderer &unset(const std::string &name) {
        check(fovolnet_renderer_unset(get(), name.c_str()));
        return *this;
    }
    void set_size(std::uint32_t width, std::uint32_t height) {
        check(fovolnet_renderer_set_size(get(), width, height));
    }
    void set_volume(const Volume &volume) { check(fovolnet_renderer_set_volume(get(), volume.get())); }
    void set_transfer_function(const TransferFunction &function) {
        check(fovolnet_renderer_set_transfer_function(get(), function.get()));
    }
    void set_camera(const Camera &camera) { check(fovolnet_renderer_set_camera(get(), camera.get())); }
    void set_light(const Light &light) { check(fovolnet_renderer_set_light(get(), light.get())); }
    void find_motion(bool finds_motion) { check(fovolnet_renderer_find_motion(get(), finds_motion ? 1 : 0)); }
    void commit() { check(fovolnet_renderer_commit(get())); }
    Frame render(std::uint32_t i = 0) {
        FovolnetFrame *frame = nullptr;
        check(fovolnet_renderer_render(get(), i, &frame));
        return Frame(frame);
    }
    Frame reference(std::uint32_t i = 0) {
        FovolnetFrame *frame = nullptr;
        check(fovolnet_renderer_reference(get(), i, &frame));
        return Frame(frame);
    }
    void reset() { check(fovolnet_renderer_reset(get())); }
    std::string notes() {
        return detail::text([this](char *text, std::size_t capacity, std::size_t *length) {
            return fovolnet_renderer_notes(get(), text, capacity, length);
        });
    }
    std::string settings() const {
        return detail::text([this](char *text, std::size_t capacity, std::size_t *length) {
            return fovolnet_renderer_settings(get(), text, capacity, length);
        });
    }
};

class Reconstructor : public detail::Handle<FovolnetReconstructor, fovolnet_reconstructor_release> {
public:
    Reconstructor(std::uint32_t width, std::uint32_t height, const std::string &json = "{}") {
        make([&](FovolnetReconstructor **made) {
            return fovolnet_reconstructor_new(width, height, json.c_str(), made);
        });
    }
    /// The full frame of `sparse`: 4 float a pixel.
    std::vector<float> reconstruct(const FovolnetSparseFrame &sparse) {
        std::vector<float> picture(std::size_t{4} * sparse.width * sparse.height);
        check(fovolnet_reconstructor_reconstruct(get(), &sparse, picture.data(), picture.size() * sizeof(float)));
        return picture;
    }
    void reset() { check(fovolnet_reconstructor_reset(get())); }
};

} // namespace fovolnet

#endif // FOVOLNET_HPP
