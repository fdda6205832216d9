#include "ingest/build/nifti.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <string_view>

#include "common/try.h"
#include "volume/header.h"

namespace diaphane::ingest {
namespace {

using Bytes = std::span<const std::byte>;

// Offsets of nifti1.h (R. Cox et al. 2004).
constexpr std::size_t kHeaderBytes = 348;
constexpr std::size_t kDim = 40, kDataType = 70, kPixDim = 76, kVoxOffset = 108, kSlope = 112,
                      kIntercept = 116, kUnits = 123, kQformCode = 252, kSformCode = 254,
                      kQuatern = 256, kQoffset = 268, kSrow = 280, kIntentName = 328, kMagic = 344;

template <typename T>
T swapped_bytes(T value) {
  auto bytes = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
  std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

template <typename T>
T at(Bytes file, std::size_t offset, bool swapped) {
  T value;
  std::memcpy(&value, file.data() + offset, sizeof value);
  return swapped ? swapped_bytes(value) : value;
}

std::string_view text_at(Bytes file, std::size_t offset, std::size_t length) {
  const std::string_view text(reinterpret_cast<const char*>(file.data()) + offset, length);
  return text.substr(0, text.find('\0'));
}

struct TypeCode {
  std::int16_t code;
  NiftiType type;
  std::size_t bytes;
};
constexpr TypeCode kTypes[] = {
    {2, NiftiType::kUint8, 1},    {4, NiftiType::kInt16, 2},    {8, NiftiType::kInt32, 4},
    {16, NiftiType::kFloat, 4},   {64, NiftiType::kDouble, 8},  {256, NiftiType::kInt8, 1},
    {512, NiftiType::kUint16, 2}, {768, NiftiType::kUint32, 4},
};

tl::unexpected<Error> damaged() {
  return fail(ErrorCode::kInvalid, "the image is damaged or incomplete");
}

/// Returns the milliseconds of a unit of time (xyzt_units), or 0 if the file does not state it.
double milliseconds_of(std::uint8_t units) {
  switch (units & 0x38) {
    case 8:
      return 1000;
    case 16:
      return 1;
    case 24:
      return 1e-3;
    default:
      return 0;
  }
}

void read_phases(Bytes file, std::size_t count, NiftiHeader& header) {
  const double step = static_cast<double>(at<float>(file, kPixDim + 16, header.swapped)) *
                      milliseconds_of(at<std::uint8_t>(file, kUnits, false));
  const bool timed = std::isfinite(step) && step > 0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto index = static_cast<double>(i);
    header.phases.push_back({timed ? volume::PhaseKind::kTime : volume::PhaseKind::kIndex,
                             timed ? index * step : index});
  }
}

Result<void> read_size(Bytes file, NiftiHeader& header) {
  const auto dim = [&](std::size_t i) {
    return at<std::int16_t>(file, kDim + 2 * i, header.swapped);
  };
  const int dimensions = dim(0);
  if (dimensions < 3 || dimensions > 7) return fail(ErrorCode::kUnsupported, "it has no depth");
  for (std::size_t i = 5; i <= static_cast<std::size_t>(dimensions); ++i) {
    if (dim(i) > 1) {
      return fail(ErrorCode::kUnsupported,
                  "this file has several values per voxel, such as colours or vectors");
    }
  }
  const std::size_t phases = dimensions >= 4 && dim(4) > 1 ? static_cast<std::size_t>(dim(4)) : 1;
  if (phases > volume::kMostPhases) {
    return fail(ErrorCode::kTooLarge,
                "it has " + std::to_string(phases) + " phases, and at most 1,000 are supported");
  }
  std::uint64_t voxels = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (dim(axis + 1) < 1) return fail(ErrorCode::kInvalid, "the image is empty");
    header.size[axis] = static_cast<std::uint32_t>(dim(axis + 1));
    voxels *= header.size[axis];
  }
  voxels *= phases;
  if (voxels > volume::kMaxVoxels) return fail(ErrorCode::kTooLarge, "the image is too large");
  if (phases > 1) read_phases(file, phases, header);
  return {};
}

/// Returns the rotation of a unit quaternion from its last three components, which the file
/// contains (method 2 of nifti1.h).
std::array<double, 9> rotation_of(double b, double c, double d) {
  double a = 1 - (b * b + c * c + d * d);
  if (a > 1e-7) {
    a = std::sqrt(a);
  } else {  // half a turn, up to rounding
    const double length = std::sqrt(b * b + c * c + d * d);
    a = 0;
    b /= length;
    c /= length;
    d /= length;
  }
  return {
      a * a + b * b - c * c - d * d, 2 * (b * c - a * d),           2 * (b * d + a * c),
      2 * (b * c + a * d),           a * a + c * c - b * b - d * d, 2 * (c * d - a * b),
      2 * (b * d - a * c),           2 * (c * d + a * b),           a * a + d * d - b * b - c * c};
}

void read_axes(Bytes file, NiftiHeader& header) {
  const auto number = [&](std::size_t offset) {
    return static_cast<double>(at<float>(file, offset, header.swapped));
  };
  const bool by_sform = at<std::int16_t>(file, kSformCode, header.swapped) > 0;
  const bool by_qform = !by_sform && at<std::int16_t>(file, kQformCode, header.swapped) > 0;
  header.has_axes = by_sform || by_qform;
  const std::array<double, 9> straight{1, 0, 0, 0, 1, 0, 0, 0, 1};
  const std::array<double, 9> turned =
      by_qform ? rotation_of(number(kQuatern), number(kQuatern + 4), number(kQuatern + 8))
               : straight;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double step = std::abs(number(kPixDim + 4 * (axis + 1)));
      const double side = by_qform && axis == 2 && number(kPixDim) < 0 ? -1 : 1;
      header.axes[3 * row + axis] =
          by_sform ? number(kSrow + 16 * row + 4 * axis) : side * step * turned[3 * row + axis];
    }
    header.origin[row] = by_sform   ? number(kSrow + 16 * row + 12)
                         : by_qform ? number(kQoffset + 4 * row)
                                    : 0;
  }
  // Converts from NIfTI's right-anterior frame to LPS.
  for (std::size_t i = 0; i < 6; ++i) header.axes[i] = -header.axes[i];
  for (std::size_t i = 0; i < 2; ++i) header.origin[i] = -header.origin[i];
}

}  // namespace

bool is_nifti(Bytes file) {
  if (file.size() < kHeaderBytes) return false;
  const auto length = at<std::int32_t>(file, 0, false);
  return (length == 348 || swapped_bytes(length) == 348) && text_at(file, kMagic, 3) == "n+1";
}

Result<NiftiHeader> read_nifti_header(Bytes file) {
  if (!is_nifti(file)) return fail(ErrorCode::kInvalid, "the file is not NIfTI");
  NiftiHeader header;
  header.swapped = at<std::int32_t>(file, 0, false) != 348;
  DIAPHANE_TRY(read_size(file, header));
  const auto code = at<std::int16_t>(file, kDataType, header.swapped);
  const auto* type = std::find_if(std::begin(kTypes), std::end(kTypes),
                                  [code](const TypeCode& one) { return one.code == code; });
  if (type == std::end(kTypes)) {
    return fail(ErrorCode::kUnsupported, "voxels of this type are not supported");
  }
  header.type = type->type;
  header.voxel_bytes = type->bytes;
  const std::uint64_t bytes = std::uint64_t{header.size[0]} * header.size[1] * header.size[2] *
                              std::max<std::size_t>(header.phases.size(), 1) * type->bytes;
  const float begin = at<float>(file, kVoxOffset, header.swapped);
  // The negated comparison also rejects NaN.
  if (!(begin >= kHeaderBytes && begin <= static_cast<float>(file.size()))) return damaged();
  header.voxels_begin = static_cast<std::size_t>(begin);
  if (header.voxels_begin > file.size() || file.size() - header.voxels_begin < bytes)
    return damaged();
  read_axes(file, header);
  const auto slope = static_cast<double>(at<float>(file, kSlope, header.swapped));
  const auto intercept = static_cast<double>(at<float>(file, kIntercept, header.swapped));
  if (std::isfinite(slope) && slope != 0 && std::isfinite(intercept)) {
    header.slope = slope;
    header.intercept = intercept;
  }
  const std::string_view modality = text_at(file, kIntentName, 16);
  for (const auto known : {volume::Modality::kCt, volume::Modality::kMr, volume::Modality::kPt}) {
    if (modality == volume::name_of(known)) header.modality = known;
  }
  return header;
}

}  // namespace diaphane::ingest
