#include "ingest/build/nifti.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

namespace diaphane::ingest {
namespace {

/// A NIfTI-1 file made by hand. The fields are those of the header, in its order.
struct Made {
  std::array<std::int16_t, 8> dim{3, 4, 3, 2, 1, 1, 1, 1};
  std::int16_t code = 4;  // int16
  float begin = 352;
  float slope = 1, intercept = 0;
  std::int16_t sform = 1;
  std::array<float, 12> srow{-0.5F, 0, 0, 0, 0, -0.7F, 0, 0, 0, 0, 1.5F, 0};  // RAS; LPS is upright
  std::string modality;
  std::string magic = "n+1";
  bool swapped = false;

  std::string with(const std::string& voxels) const {
    std::string file(352, '\0');
    put(file, 0, std::int32_t{348});
    for (std::size_t i = 0; i < 8; ++i) put(file, 40 + 2 * i, dim[i]);
    put(file, 70, code);
    for (std::size_t i = 1; i < 4; ++i) put(file, 76 + 4 * i, static_cast<float>(i));
    put(file, 108, begin);
    put(file, 112, slope);
    put(file, 116, intercept);
    put(file, 254, sform);
    for (std::size_t i = 0; i < 12; ++i) put(file, 280 + 4 * i, srow[i]);
    file.replace(328, modality.size(), modality);
    file.replace(344, magic.size(), magic);
    return file + voxels;
  }

  template <typename T>
  void put(std::string& file, std::size_t offset, T value) const {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    if (swapped) std::reverse(bytes, bytes + sizeof value);
    file.replace(offset, sizeof value, bytes, sizeof value);
  }
};

template <typename T>
std::string voxels_of(const std::vector<T>& values, bool swapped = false) {
  std::string bytes;
  for (const T value : values) {
    char one[sizeof value];
    std::memcpy(one, &value, sizeof value);
    if (swapped) std::reverse(one, one + sizeof value);
    bytes.append(one, sizeof value);
  }
  return bytes;
}

template <typename T>
std::vector<T> counted(double scale = 1) {
  std::vector<T> values;
  for (int i = 0; i < 4 * 3 * 2; ++i) values.push_back(static_cast<T>(i * scale));
  return values;
}

Result<volume::Volume> read(const std::string& file) {
  const auto bytes = std::as_bytes(std::span(file));
  const auto header = read_nifti_header(bytes);
  if (!header) return tl::unexpected(header.error());
  return read_nifti_voxels(bytes, *header);
}

/// Returns a file of NIfTI-1 as NIfTI-2 (nifti2.h), which has the same fields in other places and
/// types.
std::string as_second(const std::string& file, const Made& made) {
  std::string second(544, '\0');
  made.put(second, 0, std::int32_t{540});
  second.replace(4, 8, std::string("n+2\0\r\n\x1a\n", 8));
  made.put(second, 12, made.code);
  for (std::size_t i = 0; i < 8; ++i) made.put(second, 16 + 8 * i, std::int64_t{made.dim[i]});
  for (std::size_t i = 1; i < 4; ++i) made.put(second, 104 + 8 * i, static_cast<double>(i));
  made.put(second, 104 + 32, 0.05);
  made.put(second, 168, std::int64_t{544});
  made.put(second, 176, double{made.slope});
  made.put(second, 184, double{made.intercept});
  made.put(second, 348, std::int32_t{made.sform});
  for (std::size_t i = 0; i < 12; ++i) made.put(second, 400 + 8 * i, double{made.srow[i]});
  made.put(second, 500, std::int32_t{2 | 8});  // mm and seconds
  second.replace(508, made.modality.size(), made.modality);
  return second + file.substr(352);
}

ErrorCode refusal(const std::string& file) {
  const auto read_it = read(file);
  return read_it ? ErrorCode::kInternal : read_it.error().code;
}

TEST(Nifti, KeepsVoxelsSpacingAndModality) {
  Made made;
  made.modality = "CT";
  const auto v = read(made.with(voxels_of(counted<std::int16_t>(-40))));
  ASSERT_TRUE(v) << v.error().message;
  EXPECT_EQ(v->header.size, (std::array<std::uint32_t, 3>{4, 3, 2}));
  EXPECT_NEAR(v->header.spacing[0], 0.5, 1e-6);
  EXPECT_NEAR(v->header.spacing[1], 0.7, 1e-6);
  EXPECT_NEAR(v->header.spacing[2], 1.5, 1e-6);
  EXPECT_EQ(v->header.modality, volume::Modality::kCt);
  EXPECT_EQ(v->voxels[23], -920);
  EXPECT_TRUE(v->header.repairs.empty());
}

TEST(Nifti, ReadsEveryTypeInBothByteOrders) {
  for (const bool swapped : {false, true}) {
    const auto last = [swapped](std::int16_t code, const std::string& voxels) {
      Made made;
      made.code = code;
      made.swapped = swapped;
      const auto v = read(made.with(voxels));
      return v ? v->voxels[23] : std::numeric_limits<std::int16_t>::min();
    };
    EXPECT_EQ(last(2, voxels_of(counted<std::uint8_t>(10), swapped)), 230);
    EXPECT_EQ(last(256, voxels_of(counted<std::int8_t>(-5), swapped)), -115);
    EXPECT_EQ(last(4, voxels_of(counted<std::int16_t>(-100), swapped)), -2300);
    EXPECT_EQ(last(512, voxels_of(counted<std::uint16_t>(1000), swapped)), 23000);
    EXPECT_EQ(last(8, voxels_of(counted<std::int32_t>(-1000), swapped)), -23000);
    EXPECT_EQ(last(768, voxels_of(counted<std::uint32_t>(1000), swapped)), 23000);
    EXPECT_EQ(last(16, voxels_of(counted<float>(50.4), swapped)), 1159);
    EXPECT_EQ(last(64, voxels_of(counted<double>(50.4), swapped)), 1159);
  }
}

TEST(Nifti, ScalesLargeIntegers) {
  Made made;
  made.code = 8;
  const auto v = read(made.with(voxels_of(counted<std::int32_t>(1e6))));
  ASSERT_TRUE(v);
  EXPECT_EQ(v->voxels[23], 30000);
  EXPECT_EQ(v->header.repairs.size(), 1u);
}

TEST(Nifti, AppliesSlopeAndIntercept) {
  Made made;
  made.slope = 2;
  made.intercept = -1024;
  EXPECT_EQ(read(made.with(voxels_of(counted<std::int16_t>(100))))->voxels[23], 3576);
  made.slope = 0;  // not set
  EXPECT_EQ(read(made.with(voxels_of(counted<std::int16_t>(100))))->voxels[23], 2300);
}

TEST(Nifti, VoxelsMayBeginAnywhere) {
  Made made;
  made.begin = 353;
  EXPECT_EQ(read(made.with("x" + voxels_of(counted<std::int16_t>())))->voxels[23], 23);
}

TEST(Nifti, ReadsPhasesAndTheirTimes) {
  Made made;
  made.dim = {4, 4, 3, 2, 3, 1, 1, 1};
  std::string all;
  for (const int phase : {0, 100, 200}) {
    std::vector<std::int16_t> values = counted<std::int16_t>();
    for (std::int16_t& value : values) value = static_cast<std::int16_t>(value + phase);
    all += voxels_of(values);
  }
  std::string file = made.with(all);
  made.put(file, 76 + 16, 0.05F);
  const auto index = read(file);
  ASSERT_TRUE(index) << index.error().message;
  EXPECT_EQ(index->header.size, (std::array<std::uint32_t, 3>{4, 3, 2}));
  EXPECT_EQ(index->header.phases.at(2), (volume::Phase{volume::PhaseKind::kIndex, 2}));
  ASSERT_EQ(index->voxels.size(), 72U);
  EXPECT_EQ(index->voxels[24 + 5], 105);
  EXPECT_EQ(index->header.maximum, 223);
  file[123] = 2 | 8;  // mm and seconds
  const auto timed = read(file);
  ASSERT_EQ(timed->header.phases.size(), 3U);
  EXPECT_EQ(timed->header.phases[1].kind, volume::PhaseKind::kTime);
  EXPECT_NEAR(timed->header.phases[2].value, 100, 1e-5);
  // A left-handed file is reversed along z within each phase.
  Made mirrored = made;
  mirrored.srow[0] = 0.5F;
  const auto reversed = read(mirrored.with(all));
  ASSERT_TRUE(reversed) << reversed.error().message;
  EXPECT_EQ(reversed->voxels[24 + 5], 117);
  EXPECT_EQ(reversed->voxels[24 + 12 + 5], 105);
}

TEST(Nifti, ReadsTheSecondVersionLikeTheFirst) {
  for (const bool swapped : {false, true}) {
    Made made;
    made.swapped = swapped;
    made.slope = 2;
    made.intercept = -10;
    made.modality = "MR";
    made.dim = {4, 4, 3, 2, 2, 1, 1, 1};
    made.srow[3] = 7;
    std::vector<std::int16_t> values = counted<std::int16_t>(), later = counted<std::int16_t>(10);
    values.insert(values.end(), later.begin(), later.end());
    const std::string file = made.with(voxels_of(values, swapped));
    const auto first = read(file), second = read(as_second(file, made));
    ASSERT_TRUE(second) << second.error().message;
    EXPECT_EQ(second->voxels, first->voxels);
    EXPECT_EQ(second->header.size, first->header.size);
    EXPECT_EQ(second->header.direction, first->header.direction);
    EXPECT_EQ(second->header.origin, first->header.origin);
    EXPECT_EQ(second->header.modality, volume::Modality::kMr);
    ASSERT_EQ(second->header.phases.size(), 2U);
    EXPECT_EQ(second->header.phases[1], (volume::Phase{volume::PhaseKind::kTime, 50}));
    std::string cut = as_second(file, made);
    cut.pop_back();
    EXPECT_EQ(refusal(cut), ErrorCode::kInvalid);
    std::string huge = as_second(file, made);
    made.put(huge, 24, std::int64_t{1} << 40);
    EXPECT_EQ(refusal(huge), ErrorCode::kTooLarge);
    made.put(huge, 24, std::int64_t{-4});
    EXPECT_EQ(refusal(huge), ErrorCode::kInvalid);
    std::string before = as_second(file, made);
    made.put(before, 168, std::int64_t{-1});
    EXPECT_EQ(refusal(before), ErrorCode::kInvalid);
    EXPECT_EQ(refusal(as_second(file, made).substr(0, 500)), ErrorCode::kInvalid);
  }
}

TEST(Nifti, KeepsOnlyTheChosenPhases) {
  for (const bool swapped : {false, true}) {
    Made made;
    made.swapped = swapped;
    made.dim = {4, 4, 3, 2, 6, 1, 1, 1};
    std::vector<std::int16_t> values;
    for (std::int16_t phase = 0; phase < 6; ++phase) values.insert(values.end(), 24, phase);
    std::string first = made.with(voxels_of(values, swapped));
    made.put(first, 76 + 16, 0.05F);
    first[123] = 2 | 8;  // mm and seconds
    for (const std::string& file : {first, as_second(first, made)}) {
      const auto bytes = std::as_bytes(std::span(file));
      const auto kept = [&](const std::vector<std::uint32_t>& phases) {
        return read(keep_nifti_phases(bytes, *read_nifti_header(bytes), phases));
      };
      const auto even = kept({1, 3, 5});
      ASSERT_TRUE(even) << even.error().message;
      ASSERT_EQ(even->header.phases.size(), 3U);
      EXPECT_EQ(even->header.phases[2].kind, volume::PhaseKind::kTime);
      EXPECT_NEAR(even->header.phases[2].value, 200, 1e-4);
      for (std::size_t i = 0; i < 72; ++i) EXPECT_EQ(even->voxels[i], 1 + 2 * int(i / 24));
      EXPECT_EQ(kept({0, 1, 5})->header.phases[2], (volume::Phase{volume::PhaseKind::kIndex, 2}))
          << "times that are not evenly spaced";
      EXPECT_TRUE(kept({4})->header.phases.empty());
      EXPECT_EQ(kept({4})->voxels, std::vector<std::int16_t>(24, 4));
    }
  }
}

TEST(Nifti, ConvertsUnitsOfLength) {
  std::string file = Made().with(voxels_of(counted<std::int16_t>()));
  file[123] = 3;  // micrometres
  const auto v = read(file);
  ASSERT_TRUE(v) << v.error().message;
  EXPECT_NEAR(v->header.spacing[2], 1.5e-3, 1e-9);
}

TEST(Nifti, SaysThatTheOrientationIsUnknown) {
  Made made;
  made.sform = 0;
  const auto v = read(made.with(voxels_of(counted<std::int16_t>())));
  ASSERT_TRUE(v);
  EXPECT_NEAR(v->header.spacing[1], 2, 1e-6) << "from pixdim";
  EXPECT_EQ(v->header.repairs.size(), 1u);
}

/// Four voxels of the patient's space, each with its own value: one place, and those 5 voxels to
/// the left of it, 4 behind it and 3 above it.
struct Phantom {
  static constexpr std::array<int, 3> kSize{20, 18, 16};  // voxels towards L, P and S
  static constexpr std::array<double, 3> kStep{0.5, 0.7, 1.5};
  static constexpr std::array<std::array<int, 3>, 4> kMarks{
      {{3, 11, 6}, {8, 11, 6}, {3, 15, 6}, {3, 11, 9}}};

  /// Stored with axis a of the array along axis `order[a]` of the patient, forwards if `ahead[a]`.
  static std::string stored(const std::array<int, 3>& order, const std::array<bool, 3>& ahead) {
    Made made;
    made.srow = {};
    std::array<int, 3> size{};
    for (std::size_t a = 0; a < 3; ++a) {
      const auto axis = static_cast<std::size_t>(order[a]);
      size[a] = kSize[axis];
      made.dim[a + 1] = static_cast<std::int16_t>(size[a]);
      const double lps_to_ras = axis == 2 ? 1 : -1;
      made.srow[4 * axis + a] =
          static_cast<float>(lps_to_ras * (ahead[a] ? kStep[axis] : -kStep[axis]));
    }
    std::vector<std::int16_t> voxels(20 * 18 * 16);
    for (std::size_t mark = 0; mark < 4; ++mark) {
      std::array<int, 3> at{};
      for (std::size_t a = 0; a < 3; ++a) {
        const int along = kMarks[mark][static_cast<std::size_t>(order[a])];
        at[a] = ahead[a] ? along : size[a] - 1 - along;
      }
      voxels[static_cast<std::size_t>(at[0] + size[0] * (at[1] + size[1] * at[2]))] =
          static_cast<std::int16_t>(mark + 1);
    }
    return made.with(voxels_of(voxels));
  }
};

/// Where the voxel with this value lies, in mm (LPS), relative to the first voxel.
std::array<double, 3> place_of(const volume::Volume& v, std::int16_t value) {
  const auto found = std::find(v.voxels.begin(), v.voxels.end(), value) - v.voxels.begin();
  const std::ptrdiff_t x = v.header.size[0], y = v.header.size[1];
  const std::array<std::ptrdiff_t, 3> at{found % x, found / x % y, found / (x * y)};
  std::array<double, 3> place{};
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t axis = 0; axis < 3; ++axis)
      place[row] += v.header.direction[3 * row + axis] * v.header.spacing[axis] * double(at[axis]);
  return place;
}

TEST(Nifti, AllOrientationsShowTheSamePatient) {
  std::array<int, 3> order{0, 1, 2};
  int orientations = 0;
  do {
    for (int signs = 0; signs < 8; ++signs, ++orientations) {
      const std::array<bool, 3> ahead{(signs & 1) != 0, (signs & 2) != 0, (signs & 4) != 0};
      const auto v = read(Phantom::stored(order, ahead));
      ASSERT_TRUE(v) << v.error().message;
      const auto from = place_of(*v, 1);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto to = place_of(*v, static_cast<std::int16_t>(axis + 2));
        for (std::size_t row = 0; row < 3; ++row) {
          const double step = Phantom::kMarks[axis + 1][row] - Phantom::kMarks[0][row];
          EXPECT_NEAR(to[row] - from[row], step * Phantom::kStep[row], 1e-5)
              << "order " << order[0] << order[1] << order[2] << ", signs " << signs;
        }
      }
    }
  } while (std::next_permutation(order.begin(), order.end()));
  EXPECT_EQ(orientations, 48);
}

TEST(Nifti, RefusesWhatItCannotShow) {
  const std::string voxels = voxels_of(counted<std::int16_t>());
  const auto changed = [&](auto change) {
    Made made;
    change(made);
    return refusal(made.with(voxels));
  };
  const auto nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(changed([](Made& m) { m.magic = "ni1"; }), ErrorCode::kInvalid);
  EXPECT_EQ(changed([](Made& m) { m.dim[0] = 4, m.dim[4] = 10; }), ErrorCode::kInvalid)
      << "the voxels of one phase only";
  EXPECT_EQ(changed([](Made& m) { m.dim[0] = 4, m.dim[4] = 1001; }), ErrorCode::kTooLarge);
  EXPECT_EQ(changed([](Made& m) { m.dim[0] = 5, m.dim[5] = 3; }), ErrorCode::kUnsupported);
  EXPECT_EQ(changed([](Made& m) { m.dim[0] = 2; }), ErrorCode::kUnsupported);
  EXPECT_EQ(changed([](Made& m) { m.dim[2] = 0; }), ErrorCode::kInvalid);
  EXPECT_EQ(changed([](Made& m) { m.dim[2] = 30000; }), ErrorCode::kInvalid) << "not so many bytes";
  EXPECT_EQ(changed([](Made& m) { m.dim = {3, 32767, 32767, 32767, 1, 1, 1, 1}; }),
            ErrorCode::kTooLarge);
  EXPECT_EQ(changed([](Made& m) { m.code = 128; }), ErrorCode::kUnsupported) << "colours";
  EXPECT_EQ(changed([](Made& m) { m.begin = 353; }), ErrorCode::kInvalid) << "a byte is missing";
  EXPECT_EQ(changed([](Made& m) { m.begin = 4; }), ErrorCode::kInvalid) << "within the header";
  EXPECT_EQ(changed([&](Made& m) { m.begin = nan; }), ErrorCode::kInvalid);
  EXPECT_EQ(changed([&](Made& m) { m.begin = 1e30F; }), ErrorCode::kInvalid);
  EXPECT_EQ(changed([&](Made& m) { m.srow[0] = nan; }), ErrorCode::kUnsupported);
  EXPECT_EQ(changed([](Made& m) { m.srow.fill(0); }), ErrorCode::kUnsupported);
  EXPECT_EQ(changed([](Made& m) { m.srow[1] = 0.5F; }), ErrorCode::kUnsupported) << "sheared";
  EXPECT_EQ(refusal(std::string(348, '\0')), ErrorCode::kInvalid);
  EXPECT_EQ(refusal("short"), ErrorCode::kInvalid);
}

}  // namespace
}  // namespace diaphane::ingest
