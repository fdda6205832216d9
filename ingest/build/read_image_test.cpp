#include "ingest/build/read_image.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

namespace diaphane::ingest {
namespace {

namespace fs = std::filesystem;

class ReadImage : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "diaphane-image-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string put(const std::string& name, const std::string& bytes) const {
    const std::string path = (folder_ / name).string();
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  fs::path folder_;
};

constexpr int kX = 4, kY = 3, kZ = 2;

/// Distinct voxels of type T.
template <typename T>
std::string voxels(double scale = 1) {
  std::string bytes;
  for (int i = 0; i < kX * kY * kZ; ++i) {
    const T value = static_cast<T>(i * scale);
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  return bytes;
}

std::string mha(const std::string& type, const std::string& data,
                const std::string& matrix = "1 0 0 0 1 0 0 0 1") {
  return "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
         "CompressedData = False\nTransformMatrix = " +
         matrix +
         "\nOffset = 0 0 0\nElementSpacing = 0.5 0.7 1.5\nDimSize = 4 3 2\nElementType = " + type +
         "\nElementDataFile = LOCAL\n" + data;
}

TEST_F(ReadImage, ReadsMetaImageWithItsSpacing) {
  auto v = read_image(put("a.mha", mha("MET_SHORT", voxels<std::int16_t>(-100))));
  ASSERT_TRUE(v.has_value()) << v.error().message;
  EXPECT_EQ(v->header.size, (std::array<std::uint32_t, 3>{4, 3, 2}));
  EXPECT_NEAR(v->header.spacing[0], 0.5, 1e-9);
  EXPECT_NEAR(v->header.spacing[1], 0.7, 1e-9);
  EXPECT_NEAR(v->header.spacing[2], 1.5, 1e-9);
  for (int i = 0; i < 24; ++i) EXPECT_EQ(v->voxels[static_cast<std::size_t>(i)], -100 * i);
  EXPECT_EQ(v->header.minimum, -2300);
  EXPECT_TRUE(v->header.repairs.empty());
}

TEST_F(ReadImage, ReadsMetaImageAxesInOrder) {
  // x goes to the back, y to the head, z to the left.
  auto v = read_image(put("a.mha", mha("MET_SHORT", voxels<std::int16_t>(), "0 1 0 0 0 1 1 0 0")));
  ASSERT_TRUE(v.has_value()) << v.error().message;
  EXPECT_EQ(v->header.direction, (std::array<double, 9>{0, 0, 1, 1, 0, 0, 0, 1, 0}));
}

TEST_F(ReadImage, ReversesSlicesOfLeftHandedAxesWithoutMirroring) {
  auto v = read_image(put("a.mha", mha("MET_SHORT", voxels<std::int16_t>(), "1 0 0 0 1 0 0 0 -1")));
  ASSERT_TRUE(v.has_value()) << v.error().message;
  EXPECT_EQ(v->header.direction, (std::array<double, 9>{1, 0, 0, 0, 1, 0, 0, 0, 1}));
  EXPECT_EQ(v->voxels[0], 12) << "the slice that was last lies lowest";
  EXPECT_EQ(v->voxels[12], 0);
}

TEST_F(ReadImage, ConvertsTypesToInt16) {
  EXPECT_EQ(read_image(put("a.mha", mha("MET_UCHAR", voxels<std::uint8_t>(10))))->voxels[23], 230);
  EXPECT_EQ(read_image(put("b.mha", mha("MET_USHORT", voxels<std::uint16_t>(1000))))->voxels[23],
            23000);
  EXPECT_EQ(read_image(put("c.mha", mha("MET_FLOAT", voxels<float>(50.4))))->voxels[23],
            std::lround(23 * 50.4));
}

TEST_F(ReadImage, ScalesValuesThatDoNotFitAndReportsIt) {
  auto v = read_image(put("a.mha", mha("MET_USHORT", voxels<std::uint16_t>(2800))));
  ASSERT_TRUE(v.has_value());
  EXPECT_EQ(v->voxels[23], 23 * 1400);
  EXPECT_EQ(v->header.repairs.size(), 1u);
  v = read_image(put("b.mha", mha("MET_FLOAT", voxels<float>(1.0 / 23))));
  ASSERT_TRUE(v.has_value());
  EXPECT_EQ(v->voxels[23], 30000) << "values from 0 to 1 would all be 0 or 1";
  EXPECT_EQ(v->header.repairs.size(), 1u);
}

TEST_F(ReadImage, RefusesOtherTypesAndShapesWithAMessage) {
  const auto code = [&](const std::string& name, const std::string& bytes) {
    auto v = read_image(put(name, bytes));
    EXPECT_FALSE(v.has_value()) << name;
    if (v) return ErrorCode::kInternal;
    EXPECT_GT(v.error().message.size(), 10u);
    return v.error().code;
  };
  EXPECT_EQ(code("a.mha", mha("MET_LONG_LONG", voxels<std::int64_t>())), ErrorCode::kUnsupported);
  EXPECT_EQ(code("b.mha", mha("MET_SHORT", voxels<std::int16_t>(), "1 0 0 0.5 1 0 0 0 1")),
            ErrorCode::kUnsupported);
  EXPECT_EQ(code("c.mha", mha("MET_SHORT", voxels<std::int16_t>().substr(0, 30))),
            ErrorCode::kInvalid);
  EXPECT_EQ(code("d.mha", "this is not an image"), ErrorCode::kInvalid);
  EXPECT_EQ(code("e.mha", ""), ErrorCode::kInvalid);
  EXPECT_EQ(code("f.nii", std::string(500, 'x')), ErrorCode::kInvalid);
  EXPECT_EQ(code("g.nii.gz", std::string(500, 'x')), ErrorCode::kInvalid);
  EXPECT_EQ(code("h.nrrd", std::string(500, 'x')), ErrorCode::kInvalid);
  EXPECT_EQ(code("i.png", "x"), ErrorCode::kUnsupported);
  EXPECT_EQ(read_image((folder_ / "none.mha").string()).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(read_image(folder_.string()).error().code, ErrorCode::kNotFound);
  std::string huge = mha("MET_SHORT", "");
  huge.replace(huge.find("4 3 2"), 5, "60000 60000 60000");
  EXPECT_EQ(code("j.mha", huge), ErrorCode::kTooLarge);
}

TEST_F(ReadImage, ReadsRawFileOfAnMhd) {
  put("a.raw", voxels<std::int16_t>());
  std::string header = mha("MET_SHORT", "");
  header.replace(header.find("LOCAL"), 5, "a.raw");
  auto v = read_image(put("a.mhd", header));
  ASSERT_TRUE(v.has_value()) << v.error().message;
  EXPECT_EQ(v->voxels[23], 23);
}

/// A NIfTI-1 file (nifti1.h) of int16 with an sform whose columns are the steps in mm, RAS.
std::string nifti(const std::array<float, 12>& rows, float slope = 0, std::int16_t times = 1) {
  std::string h(352, '\0');
  const auto set = [&](std::size_t at, auto value) {
    std::memcpy(h.data() + at, &value, sizeof value);
  };
  set(0, std::int32_t{348});
  const std::int16_t dim[] = {
      static_cast<std::int16_t>(times > 1 ? 4 : 3), kX, kY, kZ, times, 1, 1, 1};
  for (std::size_t i = 0; i < 8; ++i) set(40 + 2 * i, dim[i]);
  set(70, std::int16_t{4});  // int16
  set(72, std::int16_t{16});
  const float pixdim[] = {1, 0.5F, 0.7F, 1.5F, 1, 1, 1, 1};
  for (std::size_t i = 0; i < 8; ++i) set(76 + 4 * i, pixdim[i]);
  set(108, 352.0F);
  set(112, slope);
  set(254, std::int16_t{1});  // sform_code
  for (std::size_t i = 0; i < 12; ++i) set(280 + 4 * i, rows[i]);
  std::memcpy(h.data() + 344, "n+1", 4);
  std::string data;
  for (int t = 0; t < times; ++t) data += voxels<std::int16_t>();
  return h + data;
}

TEST_F(ReadImage, ConvertsNiftiFromRasToLps) {
  // x to the right, y to the front and z to the head are -x, -y, z in LPS, which is right-handed.
  auto v = read_image(put("a.nii", nifti({0.5F, 0, 0, 0, 0, 0.7F, 0, 0, 0, 0, 1.5F, 0})));
  ASSERT_TRUE(v.has_value()) << v.error().message;
  const std::array<double, 9> expected{-1, 0, 0, 0, -1, 0, 0, 0, 1};
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(v->header.direction[i], expected[i], 1e-6);
  EXPECT_NEAR(v->header.spacing[1], 0.7, 1e-6);
  EXPECT_EQ(v->voxels[5], 5);
}

TEST_F(ReadImage, DoesNotMirrorLeftHandedNifti) {
  // Stored with x to the left (radiological): voxel 0, 0, 0 is at the right, front, foot corner.
  auto v = read_image(put("a.nii", nifti({-0.5F, 0, 0, 0, 0, 0.7F, 0, 0, 0, 0, 1.5F, 0})));
  ASSERT_TRUE(v.has_value()) << v.error().message;
  const auto& d = v->header.direction;
  const double det = d[0] * (d[4] * d[8] - d[5] * d[7]) - d[1] * (d[3] * d[8] - d[5] * d[6]) +
                     d[2] * (d[3] * d[7] - d[4] * d[6]);
  EXPECT_NEAR(det, 1, 1e-6);
  // Wherever voxel 0 is, its neighbours along the patient's axes are the same as before: one step
  // to the left (+x in LPS) is number 1, one to the front (-y) is 4, and one to the head (+z) is
  // 12.
  std::size_t at = 0;
  while (v->voxels[at] != 0) ++at;
  const int x = static_cast<int>(at) % kX, y = static_cast<int>(at) / kX % kY,
            z = static_cast<int>(at) / (kX * kY);
  const auto neighbour = [&](std::array<double, 3> to) {
    int step[3];
    for (std::size_t a = 0; a < 3; ++a) {
      step[a] = static_cast<int>(std::lround(d[a] * to[0] + d[3 + a] * to[1] + d[6 + a] * to[2]));
    }
    return v
        ->voxels[static_cast<std::size_t>(x + step[0] + kX * (y + step[1] + kY * (z + step[2])))];
  };
  EXPECT_EQ(neighbour({1, 0, 0}), 1);
  EXPECT_EQ(neighbour({0, -1, 0}), 4);
  EXPECT_EQ(neighbour({0, 0, 1}), 12);
}

TEST_F(ReadImage, ReadsCompressedAndScaledNifti) {
  const std::string plain = nifti({0.5F, 0, 0, 0, 0, 0.7F, 0, 0, 0, 0, 1.5F, 0}, 20);
  const std::string path = (folder_ / "a.nii.gz").string();
  gzFile out = gzopen(path.c_str(), "wb");
  gzwrite(out, plain.data(), static_cast<unsigned>(plain.size()));
  gzclose(out);
  auto v = read_image(path);
  ASSERT_TRUE(v.has_value()) << v.error().message;
  EXPECT_EQ(v->voxels[23], 460);
}

TEST_F(ReadImage, ReadsThePhasesOfNiftiFilesPackedOrNot) {
  const std::string plain = nifti({-0.5F, 0, 0, 0, 0, -0.7F, 0, 0, 0, 0, 1.5F, 0}, 0, 3);
  const std::string packed = (folder_ / "b.nii.gz").string();
  gzFile out = gzopen(packed.c_str(), "wb");
  gzwrite(out, plain.data(), static_cast<unsigned>(plain.size()));
  gzclose(out);
  for (const std::string& path : {put("a.nii", plain), packed}) {
    const auto v = read_image(path);
    ASSERT_TRUE(v.has_value()) << v.error().message;
    EXPECT_EQ(v->header.phases.size(), 3U);
    ASSERT_EQ(v->voxels.size(), 3 * v->header.voxel_count());
    EXPECT_EQ(v->voxels[v->header.voxel_count()], v->voxels[0]) << "every phase is the same here";
  }
}

std::string nrrd(const std::string& space, const std::string& directions, const std::string& data,
                 const std::string& encoding = "raw") {
  return "NRRD0004\ntype: short\ndimension: 3\nspace: " + space +
         "\nsizes: 12 3 2\nspace directions: " + directions +
         "\nkinds: domain domain domain\nendian: little\nencoding: " + encoding +
         "\nspace origin: (0,0,0)\n\n" + data;
}

/// 12 x 3 x 2, because VTK takes up to 9 columns for the components of a vector.
std::string long_rows() {
  std::string data;
  for (std::int16_t i = 0; i < 72; ++i) data.append(reinterpret_cast<const char*>(&i), 2);
  return data;
}

std::string gzipped(const std::string& data, const fs::path& folder) {
  const std::string path = (folder / "packed").string();
  gzFile out = gzopen(path.c_str(), "wb");
  gzwrite(out, data.data(), static_cast<unsigned>(data.size()));
  gzclose(out);
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST_F(ReadImage, ReadsNrrdWithItsDirections) {
  const std::string lps = "left-posterior-superior", turned = "(0,0.5,0) (0,0,0.7) (1.5,0,0)";
  for (const std::string encoding : {"raw", "gzip"}) {
    const std::string data = encoding == "raw" ? long_rows() : gzipped(long_rows(), folder_);
    auto v = read_image(put(encoding + ".nrrd", nrrd(lps, turned, data, encoding)));
    ASSERT_TRUE(v.has_value()) << encoding << v.error().message;
    EXPECT_EQ(v->header.direction, (std::array<double, 9>{0, 0, 1, 1, 0, 0, 0, 1, 0}));
    EXPECT_NEAR(v->header.spacing[0], 0.5, 1e-9);
    for (int i = 0; i < 72; ++i) EXPECT_EQ(v->voxels[static_cast<std::size_t>(i)], i) << encoding;
    v = read_image(put("cut.nrrd", nrrd(lps, turned, data.substr(0, data.size() / 2), encoding)));
    EXPECT_FALSE(v.has_value()) << "cut off, " << encoding;
  }
  auto v = read_image(put(
      "b.nrrd", nrrd("right-anterior-superior", "(-0.5,0,0) (0,-0.7,0) (0,0,1.5)", long_rows())));
  ASSERT_TRUE(v.has_value()) << v.error().message;
  const std::array<double, 9> straight{1, 0, 0, 0, 1, 0, 0, 0, 1};
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(v->header.direction[i], straight[i], 1e-9);
  // A left-handed space whose axes run to the left, the back and the head.
  v = read_image(
      put("c.nrrd", nrrd("left-anterior-superior", "(0.5,0,0) (0,-0.7,0) (0,0,1.5)", long_rows())));
  ASSERT_TRUE(v.has_value()) << v.error().message;
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(v->header.direction[i], straight[i], 1e-9);
  EXPECT_EQ(v->voxels[71], 71);
}

/// The value of a voxel of the phase `t` in files with phases.
std::int16_t value_of(int t, int x, int y, int z) {
  return static_cast<std::int16_t>(1000 * t + 100 * z + 10 * y + x);
}

/// The voxels of kX x kY x kZ and of kT phases, in either byte order. The phases are the axis
/// number `axis` of the file.
constexpr int kT = 5;
std::string phases_of(int axis, bool big = false) {
  std::array<int, 4> size{kX, kY, kZ, kT};  // of x, y, z and t
  std::vector<std::size_t> order{0, 1, 2};
  order.insert(order.begin() + axis, 3);
  std::string bytes;
  std::array<int, 4> at{};
  const auto loop = [&](const auto& self, int depth) -> void {
    if (depth < 0) {
      const std::int16_t value = value_of(at[3], at[0], at[1], at[2]);
      const char low = static_cast<char>(value & 255), high = static_cast<char>(value >> 8);
      bytes += big ? std::string{high, low} : std::string{low, high};
      return;
    }
    const std::size_t along = order[static_cast<std::size_t>(depth)];
    for (at[along] = 0; at[along] < size[along]; ++at[along]) self(self, depth - 1);
  };
  loop(loop, 3);
  return bytes;
}

/// Expects kT phases whose voxels are where value_of() says.
void expect_phases(const Result<volume::Volume>& v, double step_ms) {
  ASSERT_TRUE(v.has_value()) << v.error().message;
  ASSERT_EQ(v->header.phases.size(), std::size_t{kT});
  ASSERT_EQ(v->header.size, (std::array<std::uint32_t, 3>{kX, kY, kZ}));
  const auto kind = step_ms > 0 ? volume::PhaseKind::kTime : volume::PhaseKind::kIndex;
  for (int t = 0; t < kT; ++t) {
    const auto& phase = v->header.phases[static_cast<std::size_t>(t)];
    EXPECT_EQ(phase.kind, kind);
    EXPECT_NEAR(phase.value, step_ms > 0 ? t * step_ms : t, 1e-5);
  }
  std::size_t i = 0;
  for (int t = 0; t < kT; ++t)
    for (int z = 0; z < kZ; ++z)
      for (int y = 0; y < kY; ++y)
        for (int x = 0; x < kX; ++x) ASSERT_EQ(v->voxels[i++], value_of(t, x, y, z));
}

/// An NRRD whose axis number `axis` counts phases. `more`: lines of the header.
std::string nrrd_phases(int axis, const std::string& kind, const std::string& more = "",
                        const std::string& encoding = "raw", const std::string& data = "") {
  std::vector<std::string> sizes{"4", "3", "2"}, kinds(3, "domain"),
      steps{"(0.5,0,0)", "(0,0.7,0)", "(0,0,1.5)"};
  sizes.insert(sizes.begin() + axis, std::to_string(kT));
  kinds.insert(kinds.begin() + axis, kind);
  steps.insert(steps.begin() + axis, "none");
  const auto joined = [](const std::vector<std::string>& words) {
    std::string line;
    for (const std::string& word : words) line += " " + word;
    return line;
  };
  return "NRRD0004\ntype: short\ndimension: 4\nspace: left-posterior-superior\nsizes:" +
         joined(sizes) + "\nspace directions:" + joined(steps) +
         (kind.empty() ? "" : "\nkinds:" + joined(kinds)) + "\nencoding: " + encoding +
         "\nspace origin: (1,2,3)\n" + (more.empty() ? "endian: little\n" : more) + "\n" +
         (data.empty() ? phases_of(axis) : data);
}

TEST_F(ReadImage, ReadsThePhasesOfNrrdWhereverTheirAxisIs) {
  for (const int axis : {0, 1, 2, 3}) {
    for (const std::string kind : {"list", "time", "domain", "none", "???", ""}) {
      const auto v = read_image(put("a.nrrd", nrrd_phases(axis, kind)));
      SCOPED_TRACE(kind + " as axis " + std::to_string(axis));
      expect_phases(v, 0);
      ASSERT_TRUE(v.has_value());
      EXPECT_EQ(v->header.direction, (std::array<double, 9>{1, 0, 0, 0, 1, 0, 0, 0, 1}));
      EXPECT_NEAR(v->header.spacing[1], 0.7, 1e-9);
      EXPECT_EQ(v->header.origin, (std::array<double, 3>{1, 2, 3}));
    }
    expect_phases(read_image(put("big.nrrd", nrrd_phases(axis, "list", "endian: big\n", "raw",
                                                         phases_of(axis, true)))),
                  0);
    expect_phases(read_image(put("packed.nrrd", nrrd_phases(axis, "list", "", "gzip",
                                                            gzipped(phases_of(axis), folder_)))),
                  0);
  }
}

TEST_F(ReadImage, KeepsTheTimeBetweenPhasesOfNrrd) {
  const std::string seconds =
      "spacings: nan nan nan 0.04\nunits: \"\" \"\" \"\" \"s\"\nendian: little\n";
  expect_phases(read_image(put("a.nrrd", nrrd_phases(3, "time", seconds))), 40);
  const std::string unknown = "spacings: nan nan nan 0.04\nendian: little\n";
  expect_phases(read_image(put("b.nrrd", nrrd_phases(3, "time", unknown))), 0);
  const std::string space_and_time =
      "NRRD0005\ntype: short\ndimension: 4\nspace: left-posterior-superior-time\n"
      "sizes: 4 3 2 5\nspace directions: (0.5,0,0,0) (0,0.7,0,0) (0,0,1.5,0) (0,0,0,75)\n"
      "space units: \"mm\" \"mm\" \"mm\" \"ms\"\nendian: little\nencoding: raw\n\n";
  expect_phases(read_image(put("c.nrrd", space_and_time + phases_of(3))), 75);
  const std::string nothing_known =
      "NRRD0004\ntype: short\ndimension: 4\nsizes: 4 3 2 5\nendian: little\nencoding: raw\n\n";
  const auto v = read_image(put("d.nrrd", nothing_known + phases_of(3)));
  expect_phases(v, 0);
  EXPECT_EQ(v->header.repairs.size(), 1U) << "no orientation";
}

TEST_F(ReadImage, RefusesColoursAndVectorsOfNrrd) {
  const auto refusal = [&](const std::string& file) {
    const auto v = read_image(put("a.nrrd", file));
    return v ? std::string("accepted") : v.error().message;
  };
  const std::string several = "this file has several values per voxel, such as colours or vectors";
  for (const std::string kind : {"vector", "point", "covariant-vector"})
    EXPECT_EQ(refusal(nrrd_phases(0, kind)), several) << kind;
  std::string colour = nrrd_phases(0, "RGB-color");
  colour.replace(colour.find("sizes: 5"), 8, "sizes: 3");
  EXPECT_EQ(refusal(colour), several);
  std::string unnamed = nrrd_phases(0, "");
  unnamed.replace(unnamed.find("sizes: 5"), 8, "sizes: 3");
  EXPECT_EQ(refusal(unnamed), several) << "as programs that write no kinds store a colour";
  EXPECT_EQ(read_image(put("b.nrrd", nrrd_phases(3, "list").substr(0, 400))).error().code,
            ErrorCode::kInvalid);
  std::string many = nrrd_phases(3, "list");
  many.replace(many.find("2 5\n"), 4, "2 1001\n");
  EXPECT_EQ(read_image(put("c.nrrd", many)).error().code, ErrorCode::kTooLarge);
}

TEST_F(ReadImage, RefusesCompressedMetaImageThatEndsEarly) {
  std::string data(4 * 3 * 2 * 100 * 2, '\0');
  for (std::size_t i = 0; i < data.size(); ++i) data[i] = static_cast<char>(i * 31 % 127);
  std::string packed(data.size() + 1000, '\0');
  uLongf size = packed.size();
  ASSERT_EQ(compress(reinterpret_cast<Bytef*>(packed.data()), &size,
                     reinterpret_cast<const Bytef*>(data.data()), data.size()),
            Z_OK);
  packed.resize(size);
  const auto with_size = [&](std::size_t stated, const std::string& voxels) {
    std::string header = mha("MET_SHORT", "");
    const std::string none = "CompressedData = False\n", dims = "4 3 2";
    header.replace(header.find(none), none.size(),
                   "CompressedData = True\nCompressedDataSize = " + std::to_string(stated) + "\n");
    header.replace(header.find(dims), dims.size(), "40 30 2");
    return read_image(put("a.mha", header + voxels));
  };
  const auto whole = with_size(size, packed);
  ASSERT_TRUE(whole.has_value()) << whole.error().message;
  EXPECT_EQ(whole->voxels.size(), data.size() / 2);
  EXPECT_FALSE(with_size(size, packed.substr(0, size - 20)).has_value());
  EXPECT_FALSE(with_size(size - 100, packed).has_value()) << "a wrong size";
  EXPECT_FALSE(with_size(size, std::string(size, 'x')).has_value());
}

TEST_F(ReadImage, ReadsThePhasesOfMetaImage) {
  for (const bool big : {false, true}) {
    std::string header = mha("MET_SHORT", "", "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1");
    const auto change = [&](const std::string& from, const std::string& to) {
      header.replace(header.find(from), from.size(), to);
    };
    change("NDims = 3", "NDims = 4");
    change("Offset = 0 0 0", "Offset = 1 2 3 0");
    change("0.5 0.7 1.5", "0.5 0.7 1.5 40");
    change("4 3 2", "4 3 2 5");
    if (big) change("MSB = False", "MSB = True");
    const auto v = read_image(put("a.mha", header + phases_of(3, big)));
    expect_phases(v, 0);
    EXPECT_EQ(v->header.origin, (std::array<double, 3>{1, 2, 3}));
    EXPECT_NEAR(v->header.spacing[2], 1.5, 1e-9);
    EXPECT_FALSE(read_image(put("b.mha", header + phases_of(3).substr(2))).has_value());
    std::string sheared = header;
    sheared.replace(sheared.find("1 0 0 0 0 1"), 11, "1 0 0 9 0 1");
    EXPECT_EQ(read_image(put("c.mha", sheared + phases_of(3, big))).error().code,
              ErrorCode::kInvalid)
        << "an axis through space and time";
  }
}

TEST_F(ReadImage, RefusesTruncatedNifti) {
  const std::string whole = nifti({0.5F, 0, 0, 0, 0, 0.7F, 0, 0, 0, 0, 1.5F, 0});
  EXPECT_FALSE(read_image(put("a.nii", whole.substr(0, 370))).has_value());
  const std::string packed = gzipped(whole, folder_);
  EXPECT_TRUE(read_image(put("b.nii.gz", packed)).has_value());
  EXPECT_FALSE(read_image(put("c.nii.gz", packed.substr(0, packed.size() - 30))).has_value());
}

TEST(ImageNames, AreRecognizedByTheirExtension) {
  for (const char* name : {"a.mha", "A.MHD", "x/y.nii", "b.nii.gz", "c.NRRD"})
    EXPECT_TRUE(is_image_name(name));
  for (const char* name : {"a", "mha", "a.gz", "a.dcm", "a.png", "nii.gz.txt"})
    EXPECT_FALSE(is_image_name(name));
}

}  // namespace
}  // namespace diaphane::ingest
