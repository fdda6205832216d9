#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "ingest/build/read_image.h"
#include "ingest/labels/read_labels.h"

namespace diaphane::ingest {
namespace {

using Place = std::array<double, 3>;

/// A NIfTI-1 file of 16-bit numbers.
struct Nifti {
  std::array<std::int16_t, 3> size{};
  std::array<double, 9> axes{};  ///< LPS, as columns
  Place origin{};                ///< LPS
  std::vector<float> voxels;
  bool placed = true;

  std::string bytes() const {
    std::string file(352, '\0');
    const auto put = [&](std::size_t at, auto value) {
      std::memcpy(&file[at], &value, sizeof value);
    };
    put(0, std::int32_t{348});
    put(40, std::int16_t{3});
    for (std::size_t i = 0; i < 3; ++i) {
      put(42 + 2 * i, size[i]);
      const double step = std::hypot(axes[i], axes[3 + i], axes[6 + i]);
      put(80 + 4 * i, static_cast<float>(step));
    }
    put(70, std::int16_t{16});
    put(72, std::int16_t{32});
    put(76, 1.0F);
    put(108, 352.0F);
    put(254, static_cast<std::int16_t>(placed ? 1 : 0));
    for (std::size_t row = 0; row < 3; ++row) {
      const double to_ras = row == 2 ? 1 : -1;
      for (std::size_t i = 0; i < 3; ++i) {
        put(280 + 16 * row + 4 * i, static_cast<float>(to_ras * axes[3 * row + i]));
      }
      put(292 + 16 * row, static_cast<float>(to_ras * origin[row]));
    }
    std::memcpy(&file[344], "n+1", 4);
    const auto* data = reinterpret_cast<const char*>(voxels.data());
    return file + std::string(data, data + voxels.size() * sizeof(float));
  }

  std::size_t count() const {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
           static_cast<std::size_t>(size[2]);
  }
  /// Fills the voxels by the places of their centres (LPS).
  template <typename Value>
  Nifti& fill(const Value& value) {
    voxels.clear();
    for (int z = 0; z < size[2]; ++z) {
      for (int y = 0; y < size[1]; ++y) {
        for (int x = 0; x < size[0]; ++x) {
          Place at = origin;
          for (std::size_t row = 0; row < 3; ++row) {
            at[row] += axes[3 * row] * x + axes[3 * row + 1] * y + axes[3 * row + 2] * z;
          }
          voxels.push_back(static_cast<float>(value(at)));
        }
      }
    }
    return *this;
  }
};

/// One of the 48 ways to store the box from (-20, -40, 10) on, 24 x 20 x 16 voxels towards L, P, S.
Nifti stored(const std::array<std::size_t, 3>& order, unsigned reversed, double step = 1) {
  constexpr std::array<int, 3> kSize{24, 20, 16};
  constexpr Place kStep{1, 1.25, 2}, kLow{-20, -40, 10};
  Nifti file;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t axis = order[a];
    const bool back = (reversed >> a & 1) != 0;
    const double size = kStep[axis] * step;
    file.size[a] = static_cast<std::int16_t>(std::lround(kSize[axis] / step));
    file.axes[3 * axis + a] = back ? -size : size;
    file.origin[axis] = kLow[axis] + size / 2 + (back ? (file.size[a] - 1) * size : 0);
  }
  return file;
}

/// Structures of the patient: a block without any symmetry, and a smaller one in it.
int structure_at(const Place& p) {
  if (p[0] > -5 && p[0] < 1 && p[1] > -30 && p[1] < -20 && p[2] > 18 && p[2] < 24) return 300;
  if (p[0] > -15 && p[0] < 1 && p[1] > -38 && p[1] < -20 && p[2] > 14 && p[2] < 32) return 7;
  return 0;
}

Place centre_of(const volume::Header& h, std::size_t index) {
  const std::size_t x = index % h.size[0], y = index / h.size[0] % h.size[1],
                    z = index / h.size[0] / h.size[1];
  Place at = *h.origin;
  for (std::size_t row = 0; row < 3; ++row) {
    at[row] += h.direction[3 * row] * h.spacing[0] * static_cast<double>(x) +
               h.direction[3 * row + 1] * h.spacing[1] * static_cast<double>(y) +
               h.direction[3 * row + 2] * h.spacing[2] * static_cast<double>(z);
  }
  return at;
}

Result<volume::LabelSet> labels_of(const std::string& file, const volume::Header& scan) {
  return read_labels(std::as_bytes(std::span(file)), scan);
}

/// Counts the voxels whose label is not that of the patient at their place.
std::size_t wrong_voxels(const volume::LabelSet& set, const volume::Header& scan) {
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < set.labels.voxels.size(); ++i) {
    const int number = structure_at(centre_of(scan, i));
    const std::uint8_t label = set.labels.voxels[i];
    const int found = label == 0 ? 0 : static_cast<int>(set.table[label - 1].number);
    if (found != number) ++wrong;
  }
  return wrong;
}

/// Reads a scan from a file, as the command line does.
volume::Volume scan_from(const Nifti& file, const std::string& name) {
  const std::string path = (std::filesystem::temp_directory_path() / name).string();
  std::ofstream(path, std::ios::binary) << file.bytes();
  auto scan = read_image(path);
  std::filesystem::remove(path);
  return *scan;
}

std::vector<std::array<std::size_t, 3>> orders() {
  std::vector<std::array<std::size_t, 3>> all;
  std::array<std::size_t, 3> order{0, 1, 2};
  do {
    all.push_back(order);
  } while (std::next_permutation(order.begin(), order.end()));
  return all;
}

TEST(NiftiLabels, AllOrientationsOfLabelsMarkTheSamePatient) {
  Nifti upright = stored({0, 1, 2}, 0);
  const volume::Volume scan =
      scan_from(upright.fill([](const Place& p) { return p[0] + 100; }), "labels-upright.nii");
  int orientations = 0;
  for (const auto& order : orders()) {
    for (unsigned reversed = 0; reversed < 8; ++reversed, ++orientations) {
      Nifti file = stored(order, reversed);
      const auto set = labels_of(file.fill(structure_at).bytes(), scan.header);
      ASSERT_TRUE(set) << set.error().message;
      ASSERT_EQ(set->table.size(), 2U);
      EXPECT_EQ(set->table[0].number, 7U);
      EXPECT_EQ(set->table[1].number, 300U);
      EXPECT_EQ(wrong_voxels(*set, scan.header), 0U) << "reversed " << reversed;
    }
  }
  EXPECT_EQ(orientations, 48);
}

TEST(NiftiLabels, AllOrientationsOfTheScanAreMarkedAlike) {
  Nifti upright = stored({0, 1, 2}, 0);
  const std::string labels = upright.fill(structure_at).bytes();
  for (const auto& order : orders()) {
    for (unsigned reversed = 0; reversed < 8; ++reversed) {
      Nifti file = stored(order, reversed);
      const volume::Volume scan =
          scan_from(file.fill([](const Place& p) { return p[0] + 100; }), "labels-turned.nii");
      ASSERT_TRUE(scan.header.origin);
      const auto set = labels_of(labels, scan.header);
      ASSERT_TRUE(set) << set.error().message;
      EXPECT_EQ(wrong_voxels(*set, scan.header), 0U) << "reversed " << reversed;
    }
  }
}

TEST(NiftiLabels, OtherGridsAreResampledByNearestNeighbour) {
  Nifti upright = stored({0, 1, 2}, 0);
  const volume::Volume scan =
      scan_from(upright.fill([](const Place& p) { return p[0] + 100; }), "labels-scan.nii");
  Nifti fine = stored({1, 2, 0}, 5, 0.5);
  const auto set = labels_of(fine.fill(structure_at).bytes(), scan.header);
  ASSERT_TRUE(set) << set.error().message;
  EXPECT_LT(wrong_voxels(*set, scan.header), 300U) << "only at the faces of the blocks";
  Nifti part = stored({0, 1, 2}, 0);
  part.size = {16, 12, 12};
  part.origin = {-14.5, -35, 15};
  const auto some = labels_of(part.fill(structure_at).bytes(), scan.header);
  ASSERT_TRUE(some) << some.error().message;
  EXPECT_LT(wrong_voxels(*some, scan.header), 1200U) << "what the smaller grid does not cover";
  EXPECT_EQ(some->labels.voxels[0], 0);
}

TEST(NiftiLabels, WithoutAPlaceTheGridsMustBeTheSame) {
  Nifti file = stored({0, 1, 2}, 0);
  file.placed = false;
  const volume::Volume scan =
      scan_from(file.fill([](const Place& p) { return p[0] + 100; }), "labels-unplaced.nii");
  EXPECT_FALSE(scan.header.origin);
  EXPECT_TRUE(labels_of(file.fill(structure_at).bytes(), scan.header));
  Nifti smaller = stored({0, 1, 2}, 0);
  smaller.size[0] = 23;
  const auto refused = labels_of(smaller.fill(structure_at).bytes(), scan.header);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("do not belong to this scan"), std::string::npos);
}

TEST(NiftiLabels, RefusesWhatDoesNotOverlapTheScan) {
  Nifti file = stored({0, 1, 2}, 0);
  const volume::Volume scan =
      scan_from(file.fill([](const Place& p) { return p[0] + 100; }), "labels-far.nii");
  file.fill(structure_at).origin[0] += 500;
  const auto refused = labels_of(file.bytes(), scan.header);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message,
            "These labels do not belong to this scan: none of them overlaps it.");
}

TEST(NiftiLabels, RefusesOtherVolumesThanLabels) {
  Nifti file = stored({0, 1, 2}, 0);
  const volume::Volume scan =
      scan_from(file.fill([](const Place& p) { return p[0] + 100; }), "labels-scan2.nii");
  const auto refusal = [&](const auto& value) {
    const auto read = labels_of(file.fill(value).bytes(), scan.header);
    return read ? ErrorCode::kInternal : read.error().code;
  };
  EXPECT_EQ(refusal([](const Place& p) { return p[0]; }), ErrorCode::kInvalid) << "fractions";
  EXPECT_EQ(refusal([](const Place&) { return -1; }), ErrorCode::kInvalid);
  EXPECT_EQ(refusal([](const Place&) { return NAN; }), ErrorCode::kInvalid);
  EXPECT_EQ(refusal([](const Place&) { return 0; }), ErrorCode::kInvalid) << "no label";
  int n = 0;
  EXPECT_EQ(refusal([&n](const Place&) { return ++n; }), ErrorCode::kTooLarge);
}

TEST(NiftiLabels, RefusesSeveralPhases) {
  Nifti file = stored({0, 1, 2}, 0);
  const volume::Volume scan =
      scan_from(file.fill([](const Place& p) { return p[0] + 100; }), "labels-phases.nii");
  file.fill(structure_at);
  const std::vector<float> once = file.voxels;
  file.voxels.insert(file.voxels.end(), once.begin(), once.end());
  std::string bytes = file.bytes();
  bytes[40] = 4;  // dimensions
  bytes[48] = 2;  // phases
  const auto refused = labels_of(bytes, scan.header);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
}

TEST(NiftiLabels, CompressedFilesAreLimited) {
  Nifti file = stored({0, 1, 2}, 0);
  const volume::Volume scan =
      scan_from(file.fill([](const Place& p) { return p[0] + 100; }), "labels-packed.nii");
  const std::string plain = file.fill(structure_at).bytes();
  const std::string path =
      (std::filesystem::temp_directory_path() / "labels-packed.nii.gz").string();
  gzFile out = gzopen(path.c_str(), "wb");
  gzwrite(out, plain.data(), static_cast<unsigned>(plain.size()));
  gzclose(out);
  const auto set = read_label_file(path, scan.header);
  ASSERT_TRUE(set) << set.error().message;
  EXPECT_EQ(wrong_voxels(*set, scan.header), 0U);
  LabelLimits limits;
  limits.unpacked_bytes = plain.size() - 1;
  EXPECT_EQ(read_label_file(path, scan.header, limits).error().code, ErrorCode::kTooLarge);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 20);
  EXPECT_EQ(read_label_file(path, scan.header).error().code, ErrorCode::kInvalid);
  std::filesystem::remove(path);
  EXPECT_EQ(read_label_file(path, scan.header).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace diaphane::ingest
