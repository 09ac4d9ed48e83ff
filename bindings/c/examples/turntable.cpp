// Turns a camera round voxels in memory. A few per cent of the pixels are marched, and a network fills the rest:
//
//     turntable FOLDER [FRAMES]
#include <fovolnet.hpp>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

namespace {

constexpr std::uint64_t side = 48;

/// Waves in a cube, x fastest.
std::vector<float> waves() {
    std::vector<float> values;
    values.reserve(side * side * side);
    for (std::uint64_t z = 0; z < side; ++z) {
        for (std::uint64_t y = 0; y < side; ++y) {
            for (std::uint64_t x = 0; x < side; ++x) {
                const auto wave = [](std::uint64_t at, float by) { return std::sin(by * static_cast<float>(at)); };
                values.push_back(wave(x, 0.2F) * wave(y, 0.25F) * wave(z, 0.3F));
            }
        }
    }
    return values;
}

/// A committed volume of `values`, which must live as long.
fovolnet::Volume shown(const std::vector<float> &values) {
    FovolnetVoxels voxels{};
    voxels.size = sizeof voxels;
    voxels.data = values.data();
    voxels.bytes = values.size() * sizeof(float);
    voxels.dtype = FOVOLNET_F32;
    for (int axis = 0; axis < 3; ++axis) {
        voxels.dims[axis] = side;
        voxels.spacing[axis] = 1.0;
    }
    fovolnet::Volume volume(voxels);
    volume.commit();
    return volume;
}

void write(const fovolnet::Frame &frame, const std::string &path) {
    const auto info = frame.info();
    const auto pixels = frame.read(FOVOLNET_RGB8);
    std::ofstream file(path, std::ios::binary);
    file << "P6\n" << info.width << ' ' << info.height << "\n255\n";
    file.write(reinterpret_cast<const char *>(pixels.data()), static_cast<std::streamsize>(pixels.size()));
    if (!file.flush()) {
        throw std::runtime_error("cannot write " + path + "; check the folder");
    }
    std::printf("%s: %.1f %% of the pixels in %.1f ms\n", path.c_str(),
                100.0 * static_cast<double>(info.samples) / (info.width * info.height), info.total_ms);
}

void turn(const std::string &folder, unsigned frames) {
    fovolnet::check_abi();
    const auto values = waves();
    const auto volume = shown(values);
    fovolnet::Renderer renderer(volume);
    fovolnet::Camera camera;
    camera.set_fovy(40.0);
    renderer.set_json(R"({"size": [320, 240], "sampling": "compact", "reconstruct": "wnet", "pb": 0.05})");
    renderer.set_transfer_function(fovolnet::TransferFunction("inferno"));
    renderer.set_camera(camera);
    renderer.commit();
    for (unsigned i = 0; i < frames; ++i) {
        const double angle = 0.1 * i;
        camera.look_at({2.2 * std::sin(angle), 0.7, 2.2 * std::cos(angle)}, {0.0, 0.0, 0.0});
        camera.commit();
        char name[32];
        std::snprintf(name, sizeof name, "/turn_%04u.ppm", i);
        write(renderer.render(i), folder + name);
    }
}

} // namespace

int main(int count, char **arguments) {
    if (count < 2) {
        std::cerr << "usage: turntable FOLDER [FRAMES]\n";
        return 2;
    }
    try {
        turn(arguments[1], count > 2 ? static_cast<unsigned>(std::strtoul(arguments[2], nullptr, 10)) : 3);
        return 0;
    } catch (const std::exception &error) {
        std::cerr << "error: " << error.what() << '\n';
        return 1;
    }
}
