#include "ingest/build/read_image.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

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
  v = read_image(
      put("c.nrrd", nrrd("left-anterior-superior", "(0.5,0,0) (0,0.7,0) (0,0,1.5)", long_rows())));
  EXPECT_EQ(v.error().code, ErrorCode::kUnsupported);
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
