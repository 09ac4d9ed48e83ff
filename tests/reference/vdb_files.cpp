// Files of OpenVDB and NanoVDB in many variants, written by the libraries themselves, and the values that they read back.
//
// `vdb_files.py` builds and runs this program: `vdb_files FOLDER`. For every case it writes one line of JSON to standard
// output: the file, the chosen array and component, dims, spacing, origin, type, and the file of the values (f64, x fastest)
// within the box of active voxels. A case without dims is one that must be refused.

#define NANOVDB_USE_ZIP
#define NANOVDB_USE_BLOSC

#include <openvdb/openvdb.h>
#include <openvdb/io/Stream.h>
#include <openvdb/points/PointConversion.h>
#include <openvdb/tools/LevelSetSphere.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>

#include <fstream>
#include <iostream>
#include <random>

using namespace openvdb;

static std::string folder;
static int files = 0;
static int cases = 0;
static std::mt19937 noise(7);

static std::string next(const std::string& ending)
{
    char name[32];
    std::snprintf(name, sizeof name, "%04d", files++);
    return name + ending;
}

static double part(float v, int) { return v; }
static double part(double v, int) { return v; }
static double part(int32_t v, int) { return v; }
static double part(int64_t v, int) { return double(v); }
static double part(int16_t v, int) { return v; }
static double part(uint32_t v, int) { return v; }
static double part(bool v, int) { return v; }
template<typename T> static double part(const math::Vec3<T>& v, int i) { return double(v[i]); }
template<typename T> static double part(const nanovdb::Vec3<T>& v, int i) { return double(v[i]); }

/// Prints a case; `value` gives the values in `box`.
template<typename F>
static void print(const std::string& file, const std::string& array, int component, const std::string& type, int components,
    const CoordBBox& box, const Mat4d& map, const std::string& kind, F value)
{
    const std::string values = "values" + std::to_string(cases++);
    std::ofstream out(folder + "/" + values, std::ios::binary);
    for (int z = box.min()[2]; z <= box.max()[2]; ++z)
        for (int y = box.min()[1]; y <= box.max()[1]; ++y)
            for (int x = box.min()[0]; x <= box.max()[0]; ++x) {
                const double v = value(Coord(x, y, z));
                out.write(reinterpret_cast<const char*>(&v), 8);
            }
    const Vec3d origin = map.transform(Vec3d(box.min().asVec3d()));
    auto step = [&](int i) { Vec3d e(0); e[i] = 1; return map.transform3x3(e); };
    std::cout.precision(17);
    std::cout << "{\"file\": \"" << file << "\", \"array\": \"" << array << "\", \"component\": " << component << ", \"components\": " << components
              << ", \"dtype\": \"" << type << "\", \"kind\": \"" << kind << "\", \"dims\": [" << box.dim()[0] << ", " << box.dim()[1] << ", " << box.dim()[2] << "], \"origin\": ["
              << origin[0] << ", " << origin[1] << ", " << origin[2] << "], \"steps\": [";
    for (int i = 0; i < 3; ++i)
        std::cout << (i ? ", " : "") << "[" << step(i)[0] << ", " << step(i)[1] << ", " << step(i)[2] << "]";
    std::cout << "], \"values\": \"" << values << "\"}\n";
}

static void refused(const std::string& file, const std::string& kind)
{
    std::cout << "{\"file\": \"" << file << "\", \"kind\": \"" << kind << "\"}\n";
}

static std::string shortName(const GridBase& grid)
{
    const std::string type = grid.valueType();
    const bool half = grid.saveFloatAsHalf();
    if (type == "float" || type == "vec3s") return half ? "f16" : "f32";
    if (type == "double" || type == "vec3d") return half ? "f16" : "f64";
    if (type == "int32" || type == "vec3i") return "i32";
    if (type == "int64") return "i64";
    return "u8";
}

/// Prints the case of `grid`, which was read back from `file`.
template<typename GridT>
static bool describe(const std::string& file, const std::string& array, const GridBase& base, const std::string& kind)
{
    if (!base.isType<GridT>()) return false;
    const auto& grid = static_cast<const GridT&>(base);
    const auto accessor = grid.getConstAccessor();
    const int components = VecTraits<typename GridT::ValueType>::Size;
    for (int component = 0; component < components; component += 2)
        print(file, array, component, shortName(base), components, grid.evalActiveVoxelBoundingBox(),
            grid.transform().baseMap()->getAffineMap()->getMat4(), kind,
            [&](const Coord& at) { return part(accessor.getValue(at), component); });
    return true;
}

/// Reads `file` back and prints a case for each of its grids.
static void readBack(const std::string& file, const std::string& kind)
{
    GridPtrVecPtr grids;
    io::File in(folder + "/" + file);
    std::vector<std::string> names;
    if (kind == "stream") {
        std::ifstream stream(folder + "/" + file, std::ios::binary);
        grids = io::Stream(stream, false).getGrids();
        for (auto& grid : *grids) names.push_back(grid->getName());
    } else {
        in.open(false);
        grids.reset(new GridPtrVec);
        for (auto name = in.beginName(); name != in.endName(); ++name) {
            grids->push_back(in.readGrid(name.gridName()));
            names.push_back(name.gridName());
        }
    }
    for (size_t i = 0; i < grids->size(); ++i) {
        const GridBase& grid = *(*grids)[i];
        if (!(describe<FloatGrid>(file, names[i], grid, kind) || describe<DoubleGrid>(file, names[i], grid, kind) || describe<Int32Grid>(file, names[i], grid, kind)
            || describe<Int64Grid>(file, names[i], grid, kind) || describe<BoolGrid>(file, names[i], grid, kind) || describe<MaskGrid>(file, names[i], grid, kind)
            || describe<Vec3SGrid>(file, names[i], grid, kind) || describe<Vec3DGrid>(file, names[i], grid, kind) || describe<Vec3IGrid>(file, names[i], grid, kind)))
            std::cerr << "no description of " << grid.type() << "\n";
    }
}

static void save(const GridPtrVec& grids, uint32_t compression, const std::string& kind)
{
    const std::string file = next(".vdb");
    io::File out(folder + "/" + file);
    out.setCompression(compression);
    out.write(grids);
    out.close();
    readBack(file, kind);
}

template<typename T> static T random(double scale) { return T(std::uniform_real_distribution<double>(-scale, scale)(noise)); }
template<> bool random<bool>(double) { return noise() & 1; }
template<> Vec3s random<Vec3s>(double s) { return Vec3s(random<float>(s), random<float>(s), random<float>(s)); }
template<> Vec3d random<Vec3d>(double s) { return Vec3d(random<double>(s), random<double>(s), random<double>(s)); }
template<> Vec3i random<Vec3i>(double s) { return Vec3i(random<int>(s), random<int>(s), random<int>(s)); }

/// A grid of scattered active voxels, active and inactive tiles, and inactive voxels of `others` values.
template<typename GridT>
static typename GridT::Ptr scattered(typename GridT::ValueType background, int others)
{
    using T = typename GridT::ValueType;
    auto grid = GridT::create(background);
    grid->setName("density");
    auto accessor = grid->getAccessor();
    for (int i = 0; i < 200; ++i)
        accessor.setValue(Coord(int(noise() % 30) - 17, int(noise() % 25) - 3, int(noise() % 20) - 9), random<T>(100));
    std::vector<T> inactive{background, T(math::negative(background))};
    for (int i = 2; i < others; ++i) inactive.push_back(random<T>(9));
    for (int i = 0; others > 1 && i < 300; ++i) {
        const Coord at(int(noise() % 30) - 17, int(noise() % 25) - 3, int(noise() % 20) - 9);
        if (!accessor.isValueOn(at)) accessor.setValueOff(at, inactive[noise() % inactive.size()]);
    }
    grid->tree().addTile(1, Coord(-8, 8, -8), random<T>(5), true);
    grid->tree().addTile(1, Coord(0, 0, 0), random<T>(5), false);
    return grid;
}

template<typename T> static T whole(double v) { return T(v); }
template<> bool whole<bool>(double v) { return v > 2; }

template<typename GridT>
static void everyCompression(const std::string& kind, bool hasHalf)
{
    using T = typename GridT::ValueType;
    for (uint32_t compression : {0u, 1u, 2u, 3u, 4u, 6u})
        for (int others : {1, 2, 3, 4, 9})
            for (double background : {0.0, 3.0})
                for (bool half : {false, true}) {
                    if (half && !hasHalf) continue;
                    auto grid = scattered<GridT>(whole<T>(background), others);
                    grid->setSaveFloatAsHalf(half);
                    save({grid}, compression, kind);
                }
}

template<typename GridT>
static void typed(const std::string& kind)
{
    using T = typename GridT::ValueType;
    for (uint32_t compression : {0u, 3u, 6u}) save({scattered<GridT>(whole<T>(3.0), 4)}, compression, kind);
}

static FloatGrid::Ptr small()
{
    auto grid = FloatGrid::create(0);
    grid->setName("density");
    auto accessor = grid->getAccessor();
    for (int i = 0; i < 60; ++i) accessor.setValue(Coord(i % 5 + 3, i / 5 % 4 - 2, i / 20 + 6), float(i));
    return grid;
}

static void transforms()
{
    std::vector<math::MapBase::Ptr> maps{
        math::MapBase::Ptr(new math::UniformScaleMap(0.25)), math::MapBase::Ptr(new math::ScaleMap(Vec3d(1, 2, 0.5))),
        math::MapBase::Ptr(new math::TranslationMap(Vec3d(1, -2, 3))), math::MapBase::Ptr(new math::ScaleTranslateMap(Vec3d(1, 2, 0.5), Vec3d(7, 8, 9))),
        math::MapBase::Ptr(new math::UniformScaleTranslateMap(0.1, Vec3d(7, 8, 9))), math::MapBase::Ptr(new math::UnitaryMap(Vec3d(0, 0, 1), 0.5)),
    };
    Mat4d matrix = Mat4d::identity();
    matrix.postRotate(math::X_AXIS, 0.3);
    matrix.preScale(Vec3d(1, 2, 3));
    matrix.postTranslate(Vec3d(5, 6, 7));
    maps.push_back(math::MapBase::Ptr(new math::AffineMap(matrix)));
    for (auto& map : maps) {
        auto grid = small();
        grid->setTransform(math::Transform::Ptr(new math::Transform(map)));
        save({grid}, 6, "transform " + map->type());
    }
    auto grid = small();
    grid->setTransform(math::Transform::createFrustumTransform(BBoxd(Vec3d(0), Vec3d(20)), 0.5, 10, 1));
    const std::string file = next(".vdb");
    io::File(folder + "/" + file).write({grid});
    refused(file, "frustum");
}

static void several()
{
    auto a = small(), b = small();
    b->setName("temperature");
    auto v = scattered<Vec3SGrid>(Vec3s(0), 1);
    v->setName("velocity");
    save({b, v, a}, 6, "several");
    save({a, a->deepCopy(), small()}, 3, "same names");
    // Two grids that share a tree.
    auto shared = FloatGrid::create(a->treePtr());
    shared->setName("moved");
    shared->setTransform(math::Transform::createLinearTransform(0.5));
    save({a, shared}, 6, "instance");
    auto flags = scattered<BoolGrid>(false, 2);
    flags->setName("flags");
    for (uint32_t compression : {0u, 3u, 6u}) {
        const std::string file = next(".vdb");
        std::ofstream out(folder + "/" + file, std::ios::binary);
        io::Stream stream(out);
        stream.setCompression(compression);
        stream.write(GridPtrVec{v, a, shared, flags});
        out.close();
        readBack(file, "stream");
    }
    auto empty = FloatGrid::create(1);
    std::string file = next(".vdb");
    io::File(folder + "/" + file).write({empty});
    refused(file, "empty");
    file = next(".vdb");
    io::File(folder + "/" + file).write({});
    refused(file, "no grids");
    auto points = points::createPointDataGrid<points::NullCodec, points::PointDataGrid>(std::vector<Vec3f>{Vec3f(1), Vec3f(2)}, *math::Transform::createLinearTransform(1.0));
    file = next(".vdb");
    io::File(folder + "/" + file).write({points});
    refused(file, "points");
    auto far = FloatGrid::create(0);
    far->tree().setValue(Coord(0), 1);
    far->tree().setValue(Coord(2000000000), 1);
    file = next(".vdb");
    io::File(folder + "/" + file).write({far});
    refused(file, "far apart");
}

static void shapes()
{
    auto sphere = tools::createLevelSetSphere<FloatGrid>(14, Vec3f(3, 40, -20), 1.0);
    sphere->setName("surface");
    for (bool half : {false, true})
        for (uint32_t compression : {2u, 3u, 6u}) {
            sphere->setSaveFloatAsHalf(half);
            save({sphere}, compression, "level set");
        }
    auto fog = sphere->deepCopy();
    tools::sdfToFogVolume(*fog);
    fog->setName("density");
    fog->setSaveFloatAsHalf(false);
    save({fog}, 6, "fog");
    auto tiles = FloatGrid::create(0);
    tiles->fill(CoordBBox(Coord(-5), Coord(140, 20, 20)), 2.5f);
    tiles->tree().prune();
    save({tiles}, 6, "tiles");
    auto large = FloatGrid::create(-1);
    large->tree().addTile(2, Coord(0), 4.0f, true);
    large->tree().addTile(3, Coord(4096, 0, 0), 4.0f, false);
    save({large}, 6, "large tile");
    tiles->setName("density");
    auto other = FloatGrid::create(0.5);
    other->tree().setValue(Coord(-4096, 3, 4), 1);
    other->tree().setValue(Coord(-4090, 5, 6), 1);
    save({other}, 6, "border");
}

// NanoVDB

template<typename BuildT>
static void readNano(const std::string& file, const std::string& type, const std::string& kind)
{
    auto metas = nanovdb::io::readGridMetaData(folder + "/" + file);
    for (size_t i = 0; i < metas.size(); ++i) {
        auto handle = nanovdb::io::readGrid(folder + "/" + file, i);
        auto* grid = handle.template grid<BuildT>();
        if (!grid) { std::cerr << "no NanoVDB grid in " << file << "\n"; continue; }
        auto box = grid->indexBBox();
        const CoordBBox open(Coord(box.min()[0], box.min()[1], box.min()[2]), Coord(box.max()[0], box.max()[1], box.max()[2]));
        const auto& m = grid->map();
        Mat4d map = Mat4d::identity();
        for (int r = 0; r < 3; ++r) {
            for (int c = 0; c < 3; ++c) map[c][r] = m.mMatD[3 * r + c];
            map[3][r] = m.mVecD[r];
        }
        auto accessor = grid->getAccessor();
        const int components = nanovdb::TensorTraits<typename nanovdb::NanoGrid<BuildT>::ValueType>::Rank == 1 ? 3 : 1;
        for (int component = 0; component < components; component += 2)
            print(file, grid->gridName(), component, type, components, open, map, kind,
                [&](const Coord& at) { return part(accessor.getValue(nanovdb::Coord(at[0], at[1], at[2])), component); });
    }
}

template<typename BuildT, typename GridT>
static void nano(const typename GridT::Ptr& grid, const std::string& type, const std::string& kind)
{
    for (auto codec : {nanovdb::io::Codec::NONE, nanovdb::io::Codec::ZIP, nanovdb::io::Codec::BLOSC}) {
        auto handle = nanovdb::openToNanoVDB<nanovdb::HostBuffer, typename GridT::TreeType, BuildT>(*grid);
        const std::string file = next(".nvdb");
        nanovdb::io::writeGrid(folder + "/" + file, handle, codec);
        readNano<BuildT>(file, type, kind);
    }
}

static void nanoFiles()
{
    nano<float, FloatGrid>(scattered<FloatGrid>(3, 4), "f32", "nano float");
    nano<double, DoubleGrid>(scattered<DoubleGrid>(3, 4), "f64", "nano double");
    nano<int32_t, Int32Grid>(scattered<Int32Grid>(3, 4), "i32", "nano int32");
    nano<int64_t, Int64Grid>(scattered<Int64Grid>(3, 4), "i64", "nano int64");
    nano<nanovdb::Vec3f, Vec3SGrid>(scattered<Vec3SGrid>(Vec3s(1), 2), "f32", "nano vec3f");
    nano<bool, BoolGrid>(scattered<BoolGrid>(false, 2), "u8", "nano bool");
    auto mask = MaskGrid::create();
    for (int i = 0; i < 50; ++i) mask->tree().setValueOn(Coord(int(noise() % 20), int(noise() % 9), int(noise() % 30)));
    nano<nanovdb::ValueMask, MaskGrid>(mask, "u8", "nano mask");
    auto sphere = tools::createLevelSetSphere<FloatGrid>(9, Vec3f(3, 40, -20), 1.0);
    sphere->setTransform(math::Transform::createLinearTransform(0.5));
    sphere->setName("surface");
    nano<float, FloatGrid>(sphere, "f32", "nano level set");
    nano<nanovdb::Fp4, FloatGrid>(sphere, "f32", "nano fp4");
    nano<nanovdb::Fp8, FloatGrid>(sphere, "f32", "nano fp8");
    nano<nanovdb::Fp16, FloatGrid>(sphere, "f32", "nano fp16");
    nano<nanovdb::FpN, FloatGrid>(sphere, "f32", "nano fpN");
    nano<nanovdb::FpN, FloatGrid>(scattered<FloatGrid>(0, 1), "f32", "nano fpN");
    auto tiles = FloatGrid::create(0);
    tiles->fill(CoordBBox(Coord(-5), Coord(140, 20, 20)), 2.5f);
    nano<float, FloatGrid>(tiles, "f32", "nano tiles");
    // Several grids, in one segment and in several.
    auto a = small(), b = small();
    b->setName("temperature");
    b->setTransform(math::Transform::createLinearTransform(2));
    for (auto codec : {nanovdb::io::Codec::NONE, nanovdb::io::Codec::ZIP, nanovdb::io::Codec::BLOSC}) {
        std::vector<nanovdb::GridHandle<>> handles;
        handles.push_back(nanovdb::openToNanoVDB(*a));
        handles.push_back(nanovdb::openToNanoVDB(*b));
        const std::string file = next(".nvdb");
        nanovdb::io::writeGrids(folder + "/" + file, handles, codec);
        readNano<float>(file, "f32", "nano several");
        const std::string segments = next(".nvdb");
        std::ofstream out(folder + "/" + segments, std::ios::binary);
        for (auto& handle : handles) nanovdb::io::writeGrid(out, handle, codec);
        out.close();
        readNano<float>(segments, "f32", "nano segments");
    }
}

int main(int, char** arguments)
{
    folder = arguments[1];
    initialize();
    everyCompression<FloatGrid>("float", true);
    typed<DoubleGrid>("double");
    typed<Int32Grid>("int32");
    typed<Int64Grid>("int64");
    typed<BoolGrid>("bool");
    typed<Vec3SGrid>("vec3s");
    typed<Vec3DGrid>("vec3d");
    typed<Vec3IGrid>("vec3i");
    auto half = scattered<Vec3SGrid>(Vec3s(1), 3);
    half->setSaveFloatAsHalf(true);
    save({half}, 6, "half vec3s");
    auto doubles = scattered<DoubleGrid>(0.1, 3);
    doubles->setSaveFloatAsHalf(true);
    save({doubles}, 6, "half double");
    auto mask = MaskGrid::create();
    mask->setName("mask");
    for (int i = 0; i < 50; ++i) mask->tree().setValueOn(Coord(int(noise() % 20), int(noise() % 9), int(noise() % 30)));
    for (uint32_t compression : {0u, 3u, 6u}) save({mask}, compression, "mask");
    transforms();
    several();
    shapes();
    nanoFiles();
}
