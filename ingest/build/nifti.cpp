#include "ingest/build/nifti.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <string_view>
#include <type_traits>

#include "common/try.h"
#include "volume/header.h"

namespace diaphane::ingest {
namespace {

using Bytes = std::span<const std::byte>;

/// Where the fields of a header are. The fields of NIfTI-1 and NIfTI-2 have the same meaning, but
/// other places and types (nifti1.h and nifti2.h, R. Cox et al. 2004, 2011).
struct Layout {
  std::size_t bytes;  ///< of the header
  std::string_view magic;
  std::size_t dim, data_type, pixdim, begin, slope, intercept, units, qform, sform, quatern,
      qoffset, srow, intent_name, magic_at;
};
constexpr Layout kLayouts[] = {
    {348, "n+1", 40, 70, 76, 108, 112, 116, 123, 252, 254, 256, 268, 280, 328, 344},
    {540, "n+2", 16, 12, 104, 168, 176, 184, 500, 344, 348, 352, 376, 400, 508, 4},
};

template <typename T>
T swapped_bytes(T value) {
  auto bytes = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
  std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

std::string_view text_at(Bytes file, std::size_t offset, std::size_t length) {
  const std::string_view text(reinterpret_cast<const char*>(file.data()) + offset, length);
  return text.substr(0, text.find('\0'));
}

/// The fields of a header in either byte order.
class Fields {
 public:
  Fields(Bytes file, const Layout& layout, bool swapped)
      : file_(file), layout_(layout), swapped_(swapped) {}

  /// Returns the fields of a file, or nullopt if it does not begin like NIfTI.
  static std::optional<Fields> of(Bytes file) {
    for (const Layout& layout : kLayouts) {
      if (file.size() < layout.bytes) continue;
      for (const bool swapped : {false, true}) {
        const Fields fields(file, layout, swapped);
        if (fields.at<std::int32_t>(0) == static_cast<std::int32_t>(layout.bytes) &&
            text_at(file, layout.magic_at, 4) == layout.magic) {
          return fields;
        }
      }
    }
    return std::nullopt;
  }

  const Layout& layout() const { return layout_; }
  bool is_second() const { return &layout_ == &kLayouts[1]; }
  bool swapped() const { return swapped_; }
  Bytes file() const { return file_; }

  template <typename T>
  T at(std::size_t offset) const {
    T value;
    std::memcpy(&value, file_.data() + offset, sizeof value);
    return swapped_ ? swapped_bytes(value) : value;
  }
  /// Returns number `i` of a field of numbers: float in NIfTI-1, double in NIfTI-2.
  double number(std::size_t field, std::size_t i = 0) const {
    return is_second() ? at<double>(field + 8 * i) : static_cast<double>(at<float>(field + 4 * i));
  }
  std::int64_t dim(std::size_t i) const {
    return is_second() ? at<std::int64_t>(layout_.dim + 8 * i)
                       : at<std::int16_t>(layout_.dim + 2 * i);
  }
  /// Returns a code, which has more bytes in NIfTI-2.
  std::int32_t code(std::size_t field) const {
    return is_second() ? at<std::int32_t>(field) : at<std::int16_t>(field);
  }
  /// Returns the code of the units of length and time.
  int units() const {
    return is_second() ? at<std::int32_t>(layout_.units) : at<std::uint8_t>(layout_.units);
  }
  /// Returns the offset of the voxels, or nullopt if it is not in the file.
  std::optional<std::size_t> begin() const {
    const double begin = is_second() ? static_cast<double>(at<std::int64_t>(layout_.begin))
                                     : static_cast<double>(at<float>(layout_.begin));
    // Comparisons with NaN are false.
    if (begin >= static_cast<double>(layout_.bytes) && begin <= static_cast<double>(file_.size()))
      return static_cast<std::size_t>(begin);
    return std::nullopt;
  }

 private:
  Bytes file_;
  const Layout& layout_;
  bool swapped_;
};

struct TypeCode {
  std::int16_t code;
  VoxelType type;
};
constexpr TypeCode kTypes[] = {
    {2, VoxelType::kUint8},    {4, VoxelType::kInt16},    {8, VoxelType::kInt32},
    {16, VoxelType::kFloat},   {64, VoxelType::kDouble},  {256, VoxelType::kInt8},
    {512, VoxelType::kUint16}, {768, VoxelType::kUint32},
};

/// Returns the milliseconds of a unit of time (xyzt_units), or 0 if the file does not state it.
double milliseconds_of(int units) {
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

/// Returns the millimetres of a unit of length. Most files that state none mean mm.
double millimetres_of(int units) {
  switch (units & 7) {
    case 1:
      return 1000;
    case 3:
      return 1e-3;
    default:
      return 1;
  }
}

Result<void> read_size(const Fields& fields, NiftiHeader& header) {
  const std::int64_t dimensions = fields.dim(0);
  if (dimensions < 3 || dimensions > 7) return fail(ErrorCode::kUnsupported, "it has no depth");
  for (std::size_t i = 5; i <= static_cast<std::size_t>(dimensions); ++i) {
    if (fields.dim(i) > 1) return several_values();
  }
  const std::array<std::int64_t, 3> size{fields.dim(1), fields.dim(2), fields.dim(3)};
  const std::int64_t phases = dimensions >= 4 ? std::max<std::int64_t>(fields.dim(4), 1) : 1;
  const double step = fields.number(fields.layout().pixdim, 4) * milliseconds_of(fields.units());
  return set_size(header, size, phases, step);
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

void read_axes(const Fields& fields, NiftiHeader& header) {
  const Layout& at = fields.layout();
  const bool by_sform = fields.code(at.sform) > 0;
  const bool by_qform = !by_sform && fields.code(at.qform) > 0;
  header.has_axes = by_sform || by_qform;
  const std::array<double, 9> straight{1, 0, 0, 0, 1, 0, 0, 0, 1};
  const auto quatern = [&](std::size_t i) { return fields.number(at.quatern, i); };
  const std::array<double, 9> turned =
      by_qform ? rotation_of(quatern(0), quatern(1), quatern(2)) : straight;
  const double unit = millimetres_of(fields.units());
  std::array<double, 3> origin{};
  for (std::size_t row = 0; row < 3; ++row) {
    // Converts from NIfTI's right-anterior frame to LPS.
    const double to_lps = (row < 2 ? -1 : 1) * unit;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double step = std::abs(fields.number(at.pixdim, axis + 1));
      const double side = by_qform && axis == 2 && fields.number(at.pixdim) < 0 ? -1 : 1;
      header.axes[3 * row + axis] = to_lps * (by_sform ? fields.number(at.srow, 4 * row + axis)
                                                       : side * step * turned[3 * row + axis]);
    }
    origin[row] =
        to_lps * (by_sform ? fields.number(at.srow, 4 * row + 3) : fields.number(at.qoffset, row));
  }
  if (header.has_axes) header.origin = origin;
}

}  // namespace

bool is_nifti(Bytes file) { return Fields::of(file).has_value(); }

Result<NiftiHeader> read_nifti_header(Bytes file) {
  const auto found = Fields::of(file);
  if (!found) return fail(ErrorCode::kInvalid, "the file is not NIfTI");
  const Fields& fields = *found;
  const Layout& at = fields.layout();
  NiftiHeader header;
  header.swapped = fields.swapped();
  DIAPHANE_TRY(read_size(fields, header));
  const auto code = fields.at<std::int16_t>(at.data_type);
  const auto* type = std::find_if(std::begin(kTypes), std::end(kTypes),
                                  [code](const TypeCode& one) { return one.code == code; });
  if (type == std::end(kTypes)) return unknown_type();
  header.type = type->type;
  const auto begin = fields.begin();
  if (!begin || file.size() - *begin < header.voxels_bytes()) return damaged_image();
  header.voxels_begin = *begin;
  read_axes(fields, header);
  const double slope = fields.number(at.slope), intercept = fields.number(at.intercept);
  if (std::isfinite(slope) && slope != 0 && std::isfinite(intercept)) {
    header.slope = slope;
    header.intercept = intercept;
  }
  const std::string_view modality = text_at(file, at.intent_name, 16);
  for (const auto known : {volume::Modality::kCt, volume::Modality::kMr, volume::Modality::kPt}) {
    if (modality == volume::name_of(known)) header.modality = known;
  }
  return header;
}

std::string keep_nifti_phases(Bytes file, const NiftiHeader& header,
                              std::span<const std::uint32_t> kept) {
  const auto fields = Fields::of(file);
  const Layout& layout = fields->layout();
  const auto text = [](Bytes bytes) {
    return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  };
  std::string made = text(file.first(header.voxels_begin));
  const auto put = [&](std::size_t offset, auto value) {
    if (fields->swapped()) value = swapped_bytes(value);
    std::memcpy(made.data() + offset, &value, sizeof value);
  };
  const std::size_t step = kept.size() > 1 ? kept[1] - kept[0] : 1;
  bool even = true;
  for (std::size_t i = 1; i < kept.size(); ++i) even = even && kept[i] - kept[i - 1] == step;
  const double time = even ? static_cast<double>(step) * fields->number(layout.pixdim, 4) : 0;
  if (fields->is_second()) {
    put(layout.dim + 32, static_cast<std::int64_t>(kept.size()));
    put(layout.pixdim + 32, time);
  } else {
    put(layout.dim + 8, static_cast<std::int16_t>(kept.size()));
    put(layout.pixdim + 16, static_cast<float>(time));
  }
  const std::size_t bytes = header.voxels_bytes() / std::max<std::size_t>(header.phases.size(), 1);
  for (const std::uint32_t phase : kept)
    made += text(file.subspan(header.voxels_begin + phase * bytes, bytes));
  return made;
}

}  // namespace diaphane::ingest
