#include "ingest/dicom/read_slice.h"

#include <gdcmImageReader.h>
#include <gdcmReader.h>
#include <gdcmTrace.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <istream>
#include <streambuf>

#include "ingest/dicom/values.h"

namespace diaphane::dicom {
namespace {

/// A stream over borrowed bytes.
class ByteBuffer final : public std::streambuf {
 public:
  explicit ByteBuffer(std::span<const std::byte> data) {
    char* begin = const_cast<char*>(reinterpret_cast<const char*>(data.data()));
    setg(begin, begin, begin + data.size());
  }

 protected:
  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override {
    const off_type base = from == std::ios_base::beg   ? 0
                          : from == std::ios_base::cur ? gptr() - eback()
                                                       : egptr() - eback();
    const off_type to = base + offset;
    if (to < 0 || to > egptr() - eback()) return pos_type(off_type(-1));
    setg(eback(), eback() + to, egptr());
    return to;
  }
  pos_type seekpos(pos_type to, std::ios_base::openmode which) override {
    return seekoff(off_type(to), std::ios_base::beg, which);
  }
};

void silence_gdcm() {
  // GDCM's warnings quote the contents of files.
  static const bool done = [] {
    gdcm::Trace::DebugOff();
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
    return true;
  }();
  static_cast<void>(done);
}

std::string trimmed(std::string text) {
  const auto blank = [](char c) { return c == ' ' || c == '\0'; };
  while (!text.empty() && blank(text.back())) text.pop_back();
  const auto begin = std::find_if_not(text.begin(), text.end(), blank);
  return {begin, text.end()};
}

std::optional<double> number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

/// Splits a value with several parts at its backslashes.
std::vector<std::string> split(const std::string& all) {
  std::vector<std::string> parts;
  for (std::size_t from = 0; !all.empty() && from <= all.size();) {
    const std::size_t to = std::min(all.find('\\', from), all.size());
    parts.push_back(trimmed(all.substr(from, to - from)));
    from = to + 1;
  }
  return parts;
}

/// Returns exactly N decimal strings as numbers, or nullopt.
template <std::size_t N>
std::optional<std::array<double, N>> numbers_of(const std::vector<std::string>& parts) {
  if (parts.size() != N) return std::nullopt;
  std::array<double, N> values{};
  for (std::size_t i = 0; i < N; ++i) {
    const auto value = number(parts[i]);
    if (!value) return std::nullopt;
    values[i] = *value;
  }
  return values;
}

/// Returns the number of an FD, FL or UL element from its bytes.
template <typename T>
std::optional<double> binary(std::string bytes, bool big_endian) {
  if (bytes.size() != sizeof(T)) return std::nullopt;
  if (big_endian) std::reverse(bytes.begin(), bytes.end());
  T value;
  std::memcpy(&value, bytes.data(), sizeof value);
  if (!std::isfinite(static_cast<double>(value))) return std::nullopt;
  return static_cast<double>(value);
}

class Elements {
 public:
  explicit Elements(const gdcm::DataSet& set) : set_(set) {}

  std::string text(std::uint16_t group, std::uint16_t element) const {
    const gdcm::ByteValue* value = bytes(group, element);
    if (value == nullptr || value->GetPointer() == nullptr) return {};
    return trimmed(std::string(value->GetPointer(), value->GetLength()));
  }

  std::vector<std::string> texts(std::uint16_t group, std::uint16_t element) const {
    return split(text(group, element));
  }
  template <std::size_t N>
  std::optional<std::array<double, N>> numbers(std::uint16_t group, std::uint16_t element) const {
    return numbers_of<N>(texts(group, element));
  }

  /// Returns the first of one or more decimal strings.
  std::optional<double> first(std::uint16_t group, std::uint16_t element) const {
    const std::vector<std::string> parts = texts(group, element);
    return parts.empty() ? std::nullopt : number(parts.front());
  }

  /// Returns a binary number. GDCM has converted it to the byte order of this machine.
  template <typename T>
  std::optional<double> number_of(std::uint16_t group, std::uint16_t element) const {
    const gdcm::ByteValue* value = bytes(group, element);
    if (value == nullptr || value->GetPointer() == nullptr) return std::nullopt;
    return binary<T>(std::string(value->GetPointer(), value->GetLength()), false);
  }

  /// Returns a 16-bit number. GDCM has converted it to the byte order of this machine.
  std::optional<std::uint16_t> us(std::uint16_t group, std::uint16_t element) const {
    const gdcm::ByteValue* value = bytes(group, element);
    if (value == nullptr || value->GetLength() != 2) return std::nullopt;
    std::uint16_t number = 0;
    std::copy_n(value->GetPointer(), 2, reinterpret_cast<char*>(&number));
    return number;
  }

 private:
  const gdcm::ByteValue* bytes(std::uint16_t group, std::uint16_t element) const {
    const gdcm::Tag tag(group, element);
    return set_.FindDataElement(tag) ? set_.GetDataElement(tag).GetByteValue() : nullptr;
  }

  const gdcm::DataSet& set_;
};

Kind kind_of(const std::string& sop_class, volume::Modality& modality) {
  const std::string root = "1.2.840.10008.5.1.4.1.1.";
  if (!sop_class.starts_with(root)) return Kind::kOther;
  const std::string leaf = sop_class.substr(root.size());
  using volume::Modality;
  modality = leaf == "2" || leaf.starts_with("2.")   ? Modality::kCt
             : leaf == "4" || leaf.starts_with("4.") ? Modality::kMr
             : leaf == "128" || leaf == "130"        ? Modality::kPt
             : leaf == "128.1"                       ? Modality::kPt
                                                     : Modality::kOther;
  if (leaf == "2" || leaf == "4" || leaf == "128") return Kind::kImage;
  const bool enhanced = leaf == "2.1" || leaf == "2.2" || leaf == "4.1" || leaf == "4.4" ||
                        leaf == "130" || leaf == "128.1";
  return enhanced ? Kind::kMultiFrame : Kind::kOther;
}

std::optional<std::array<double, 2>> padding_of(const Elements& in, bool is_signed) {
  const auto as_value = [&](std::uint16_t bits) {
    return is_signed ? static_cast<double>(static_cast<std::int16_t>(bits))
                     : static_cast<double>(bits);
  };
  const auto value = in.us(0x0028, 0x0120);
  if (!value) return std::nullopt;
  const double from = as_value(*value);
  const double to = as_value(in.us(0x0028, 0x0121).value_or(*value));
  return std::array{std::min(from, to), std::max(from, to)};
}

/// Returns lengths in mm if all are plausible for a scanner, otherwise nullopt, as for invalid
/// text. Sums and squares of larger numbers would overflow.
template <std::size_t N>
std::optional<std::array<double, N>> within(std::optional<std::array<double, N>> values,
                                            double least, double most) {
  const auto sane = [&](double v) {
    return v == 0 || (std::abs(v) >= least && std::abs(v) <= most);
  };
  if (values && !std::all_of(values->begin(), values->end(), sane)) return std::nullopt;
  return values;
}

constexpr double kFarthest = 1e5;  ///< mm, limit of a position
constexpr double kFinest = 1e-4, kCoarsest = 1e3;

constexpr double kMsPerSecond = 1000;

std::optional<double> in_ms(std::optional<double> seconds) {
  if (seconds) *seconds *= kMsPerSecond;
  return seconds;
}

/// Returns the b-value that scanners of Siemens, GE and Philips write into private elements of
/// files without the standard one. The same rules are in frontend/src/scan/private_b_value.ts.
std::optional<double> private_b_value(const Elements& in) {
  constexpr double kImplausible = 1e5;  ///< s/mm², far above those of scanners
  std::optional<double> value;
  if (in.text(0x0019, 0x0010) == "SIEMENS MR HEADER") {
    value = in.first(0x0019, 0x100C);
  } else if (in.text(0x0043, 0x0010) == "GEMS_PARM_01") {
    value = in.first(0x0043, 0x1039);
    // Some versions add 10⁹ as a mark.
    if (value && *value >= 1e9) *value = std::fmod(*value, kImplausible);
  } else if (in.text(0x2001, 0x0010) == "Philips Imaging DD 001") {
    value = in.number_of<float>(0x2001, 0x1003);
  }
  return value && *value >= 0 && *value < kImplausible ? value : std::nullopt;
}

/// Reads what may distinguish the slice from others at its position.
void read_moment(const Elements& in, Slice& slice) {
  const auto either = [](std::optional<double> a, std::optional<double> b) { return a ? a : b; };
  slice.by(Distinction::kBValue) =
      either(in.number_of<double>(0x0018, 0x9087), private_b_value(in));
  slice.by(Distinction::kEchoTime) =
      either(in.first(0x0018, 0x0081), in.number_of<double>(0x0018, 0x9082));
  slice.by(Distinction::kCycle) = in.number_of<float>(0x0020, 0x9241);
  slice.by(Distinction::kTriggerTime) =
      either(in.first(0x0018, 0x1060), in.number_of<double>(0x0020, 0x9153));
  slice.by(Distinction::kTimeOffset) = in_ms(in.number_of<double>(0x0020, 0x930D));
  slice.by(Distinction::kTemporalPosition) =
      either(in.first(0x0020, 0x0100), in.number_of<std::uint32_t>(0x0020, 0x9128));
  // The text of a time of day sorts like its number.
  slice.by(Distinction::kAcquisitionTime) = in.first(0x0008, 0x0032);
  slice.by(Distinction::kContentTime) = in.first(0x0008, 0x0033);
  slice.by(Distinction::kInstance) = in.first(0x0020, 0x0013);
}

Slice slice_of(const Elements& in) {
  Slice slice;
  slice.kind = kind_of(in.text(0x0008, 0x0016), slice.modality);
  slice.patient = in.text(0x0010, 0x0020) + '\n' + in.text(0x0010, 0x0010);
  slice.series_uid = in.text(0x0020, 0x000E);
  slice.sop_uid = in.text(0x0008, 0x0018);
  slice.frame_of_reference = in.text(0x0020, 0x0052);
  slice.image_type = in.texts(0x0008, 0x0008);
  slice.is_lossy = in.text(0x0028, 0x2110) == "01";
  slice.rows = in.us(0x0028, 0x0010).value_or(0);
  slice.columns = in.us(0x0028, 0x0011).value_or(0);
  slice.samples = in.us(0x0028, 0x0002).value_or(1);
  slice.frames = static_cast<std::uint64_t>(std::max(in.first(0x0028, 0x0008).value_or(1), 0.0));
  slice.photometric = in.text(0x0028, 0x0004);
  slice.layout.bits_allocated = in.us(0x0028, 0x0100).value_or(0);
  slice.layout.bits_stored = in.us(0x0028, 0x0101).value_or(slice.layout.bits_allocated);
  slice.layout.high_bit =
      in.us(0x0028, 0x0102).value_or(static_cast<std::uint16_t>(slice.layout.bits_stored - 1));
  slice.layout.is_signed = in.us(0x0028, 0x0103).value_or(0) == 1;
  const auto slope = in.first(0x0028, 0x1053);
  const auto intercept = in.first(0x0028, 0x1052);
  slice.rescale = {slope.value_or(1), intercept.value_or(0), slope && intercept};
  slice.padding = padding_of(in, slice.layout.is_signed);
  slice.position = within(in.numbers<3>(0x0020, 0x0032), 0, kFarthest);
  slice.orientation = in.numbers<6>(0x0020, 0x0037);
  slice.pixel_spacing = within(in.numbers<2>(0x0028, 0x0030), kFinest, kCoarsest);
  slice.window_center = in.first(0x0028, 0x1050).value_or(0);
  slice.window_width = std::max(in.first(0x0028, 0x1051).value_or(0), 0.0);
  read_moment(in, slice);
  return slice;
}

/// Reads what may distinguish the frame from others at its position.
void apply_moment(const GroupedText& one, bool big_endian, Slice& slice) {
  switch (one.tag) {
    case 0x00189087:
      slice.by(Distinction::kBValue) = binary<double>(one.value, big_endian);
      break;
    case 0x00189082:
      slice.by(Distinction::kEchoTime) = binary<double>(one.value, big_endian);
      break;
    case 0x00209241:
      slice.by(Distinction::kCycle) = binary<float>(one.value, big_endian);
      break;
    case 0x00209153:
      slice.by(Distinction::kTriggerTime) = binary<double>(one.value, big_endian);
      break;
    case 0x0020930D:
      slice.by(Distinction::kTimeOffset) = in_ms(binary<double>(one.value, big_endian));
      break;
    case 0x00209128:
      slice.by(Distinction::kTemporalPosition) = binary<std::uint32_t>(one.value, big_endian);
      break;
    default:
      break;
  }
}

/// Applies the values of a functional group to the slice of a frame.
void apply(const std::vector<GroupedText>& group_values, bool big_endian, Slice& slice) {
  for (const GroupedText& one : group_values) {
    apply_moment(one, big_endian, slice);
    const std::vector<std::string> parts = split(trimmed(one.value));
    const auto first = parts.empty() ? std::nullopt : number(parts.front());
    switch (one.tag) {
      case 0x00200032:
        slice.position = numbers_of<3>(parts);
        break;
      case 0x00200037:
        slice.orientation = numbers_of<6>(parts);
        break;
      case 0x00280030:
        slice.pixel_spacing = numbers_of<2>(parts);
        break;
      case 0x00281052:
        slice.rescale.intercept = first.value_or(0);
        slice.rescale.present = true;
        break;
      case 0x00281053:
        slice.rescale.slope = first.value_or(1);
        slice.rescale.present = true;
        break;
      case 0x00281050:
        slice.window_center = first.value_or(0);
        break;
      case 0x00281051:
        slice.window_width = std::max(first.value_or(0), 0.0);
        break;
      case 0x00209056:
        slice.stack = parts.empty() ? "" : parts.front();
        break;
      case 0x00089007:
        slice.image_type = parts;
        break;
      default:
        break;
    }
  }
}

/// Returns the slices of an enhanced file. Skips frames without any values, because the browser
/// marks frames that the person did not choose in this way.
std::vector<Slice> frames_of(const Precheck& checked, Slice common) {
  const std::uint64_t frames = common.frames;
  common.one_of_frames = true;
  common.frames = 1;
  apply(checked.shared, checked.syntax.big_endian, common);
  std::vector<Slice> slices;
  for (std::size_t i = 0; i < frames; ++i) {
    const bool silent = i < checked.each.size() && checked.each[i].empty();
    if (silent && frames > 1 && !common.position) continue;
    Slice& slice = slices.emplace_back(common);
    slice.frame = i;
    if (i < checked.each.size()) apply(checked.each[i], checked.syntax.big_endian, slice);
  }
  return slices;
}

}  // namespace

bool Slice::is_scout() const {
  return std::find(image_type.begin(), image_type.end(), "LOCALIZER") != image_type.end();
}

Result<std::vector<Slice>> read_slices(const Precheck& checked) {
  silence_gdcm();
  if (!checked.has_pixels)
    return std::vector{Slice{}};  // not a slice, but a report, a plan or a directory
  ByteBuffer buffer(checked.plain);
  std::istream stream(&buffer);
  gdcm::Reader reader;
  reader.SetStream(stream);
  try {
    if (!reader.ReadUpToTag(gdcm::Tag(0x7FE0, 0x0010), {})) {
      return fail(ErrorCode::kInvalid, "a file is damaged");
    }
  } catch (const std::exception&) {  // gdcm::ParseException and exceptions of the standard library
    return fail(ErrorCode::kInvalid, "a file is damaged");
  }
  Slice slice = slice_of(Elements(reader.GetFile().GetDataSet()));
  if (slice.rows != checked.rows || slice.columns != checked.columns ||
      slice.frames != checked.frames) {
    return fail(ErrorCode::kInvalid, "a file is ambiguous");
  }
  slice.has_pixels = checked.has_pixels;
  slice.has_lookup_table = checked.has_lookup_table;
  slice.is_lossy = slice.is_lossy || checked.syntax.lossy;
  if (slice.kind != Kind::kMultiFrame || !checked.has_groups) return std::vector{slice};
  if (!checked.each.empty() && checked.each.size() != checked.frames) {
    return fail(ErrorCode::kInvalid, "the number of frames is unclear");
  }
  return frames_of(checked, std::move(slice));
}

Result<Values> read_values(const Precheck& checked, const Slice& slice, double unit) {
  silence_gdcm();
  if (!checked.has_pixels) return fail(ErrorCode::kInvalid, "a slice has no pixel data");
  // Reads one frame at a time, because the file can be much larger than a slice.
  const std::vector<std::byte> one = frame_file(checked, slice.frame);
  if (one.empty()) return fail(ErrorCode::kInvalid, "the pixel data of a slice is incomplete");
  ByteBuffer buffer(one);
  std::istream stream(&buffer);
  gdcm::ImageReader reader;
  reader.SetStream(stream);
  try {
    if (!reader.Read())
      return fail(ErrorCode::kInvalid, "the pixel data of a slice cannot be read");
    const gdcm::Image& image = reader.GetImage();
    const gdcm::PixelFormat& format = image.GetPixelFormat();
    // Uses the decoder's layout, because a compressed image may hold fewer bits than the header
    // says.
    const PixelLayout layout{format.GetBitsAllocated(), format.GetBitsStored(), format.GetHighBit(),
                             format.GetPixelRepresentation() == 1};
    const std::uint64_t bytes =
        std::uint64_t{slice.rows} * slice.columns * (layout.bits_allocated / 8u);
    if (image.GetDimension(0) != slice.columns || image.GetDimension(1) != slice.rows ||
        format.GetSamplesPerPixel() != 1 || !is_readable(layout) ||
        image.GetBufferLength() != bytes) {
      return fail(ErrorCode::kInvalid, "the pixel data of a slice does not match its header");
    }
    std::vector<std::byte> raw(bytes);
    if (!image.GetBuffer(reinterpret_cast<char*>(raw.data()))) {
      return fail(ErrorCode::kInvalid, "the pixel data of a slice cannot be decoded");
    }
    return to_values(raw, layout, slice, unit);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kOutOfMemory, "a slice needs more memory than allowed");
  } catch (const std::exception&) {
    return fail(ErrorCode::kInvalid, "the pixel data of a slice cannot be decoded");
  }
}

}  // namespace diaphane::dicom
