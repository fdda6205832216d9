#include "ingest/build/image_header.h"

#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <new>
#include <set>
#include <sstream>
#include <vector>

#include "common/try.h"
#include "volume/header.h"

namespace diaphane::ingest {
namespace {

using Axes = std::array<double, 9>;

std::string trim(const std::string& text) {
  const auto is_space = [](unsigned char c) { return std::isspace(c) != 0; };
  const auto begin = std::find_if_not(text.begin(), text.end(), is_space);
  const auto end = std::find_if_not(text.rbegin(), text.rend(), is_space).base();
  return begin < end ? std::string(begin, end) : std::string();
}

/// The lines "key<separator>value" at the start of a file, up to `last_key` or an empty line.
class HeaderText {
 public:
  HeaderText(const std::string& path, char separator, const std::string& last_key) {
    std::ifstream in(path, std::ios::binary);
    std::string line;
    constexpr int kMostLines = 300;
    constexpr std::size_t kLongestLine = 4096;
    for (int n = 0; n < kMostLines && std::getline(in, line) && line.size() < kLongestLine; ++n) {
      if (in.good()) end_ = static_cast<std::uint64_t>(in.tellg());
      if (trim(line).empty()) break;
      const std::size_t at = line.find(separator);
      if (at == std::string::npos) continue;
      const std::string key = trim(line.substr(0, at));
      lines_.emplace_back(key, trim(line.substr(at + 1)));
      if (key == last_key) break;
    }
  }
  std::optional<std::string> get(const std::string& key) const {
    for (const auto& [name, value] : lines_) {
      if (name == key) return value;
    }
    return std::nullopt;
  }
  /// Offset in bytes where the lines end and voxels may begin.
  std::uint64_t end() const { return end_; }

 private:
  std::vector<std::pair<std::string, std::string>> lines_;
  std::uint64_t end_ = 0;
};

/// Parses numbers separated by blanks, commas or brackets.
std::vector<double> numbers(std::string text) {
  for (char& c : text) {
    if (c == '(' || c == ')' || c == ',') c = ' ';
  }
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  std::vector<double> values;
  for (double value = 0; in >> value;) values.push_back(value);
  return values;
}

bool all_finite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

struct VoxelType {
  const char* name;
  std::size_t bytes;
};

/// Returns the type that an NRRD calls `name`.
std::optional<VoxelType> voxel_type(const std::string& name) {
  static const std::map<std::string, VoxelType> kTypes{
      {"short", {"int16", 2}},   {"int16", {"int16", 2}},
      {"int16_t", {"int16", 2}}, {"signed short", {"int16", 2}},
      {"ushort", {"uint16", 2}}, {"unsigned short", {"uint16", 2}},
      {"uint16", {"uint16", 2}}, {"uint16_t", {"uint16", 2}},
      {"uchar", {"uint8", 1}},   {"unsigned char", {"uint8", 1}},
      {"uint8", {"uint8", 1}},   {"uint8_t", {"uint8", 1}},
      {"int8", {"int8", 1}},     {"signed char", {"int8", 1}},
      {"float", {"float", 4}},   {"double", {"double", 8}}};
  const auto found = kTypes.find(name);
  if (found == kTypes.end()) return std::nullopt;
  return found->second;
}

bool is_meta_image_type(const std::string& name) {
  static const std::set<std::string> kTypes{"MET_CHAR", "MET_UCHAR", "MET_SHORT", "MET_USHORT",
                                            "MET_INT",  "MET_UINT",  "MET_FLOAT", "MET_DOUBLE"};
  return kTypes.count(name) != 0;
}

/// Decompresses `bytes` bytes with gzip from an offset of a file.
Result<std::vector<char>> unpack(const std::string& path, std::uint64_t offset,
                                 std::uint64_t bytes) {
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0 || lseek(fd, static_cast<off_t>(offset), SEEK_SET) < 0) {
    if (fd >= 0) close(fd);
    return fail(ErrorCode::kNotFound, "the file cannot be read");
  }
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> in(gzdopen(fd, "rb"), gzclose);
  std::vector<char> unpacked;
  try {
    unpacked.resize(bytes);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kOutOfMemory, "the image does not fit in memory");
  }
  constexpr std::uint64_t kAtOnce = 1 << 26;
  for (std::uint64_t at = 0; at < bytes;) {
    const auto want = static_cast<unsigned>(std::min(kAtOnce, bytes - at));
    if (in == nullptr || gzread(in.get(), unpacked.data() + at, want) != static_cast<int>(want)) {
      return fail(ErrorCode::kInvalid, "the image is damaged or incomplete");
    }
    at += want;
  }
  return unpacked;
}

}  // namespace

Result<std::vector<std::byte>> unpacked_file(const std::string& path) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> in(gzopen(path.c_str(), "rb"), gzclose);
  if (in == nullptr) return fail(ErrorCode::kNotFound, "the file cannot be read");
  constexpr std::size_t kPiece = 1 << 26;
  std::vector<std::byte> bytes;
  try {
    for (std::size_t size = 0;; size = bytes.size()) {
      bytes.resize(size + kPiece);
      const int got = gzread(in.get(), bytes.data() + size, kPiece);
      if (got < 0) return fail(ErrorCode::kInvalid, "the image is damaged or incomplete");
      bytes.resize(size + static_cast<std::size_t>(got));
      if (got == 0) return bytes;
      if (bytes.size() > 8 * volume::kMaxVoxels)
        return fail(ErrorCode::kTooLarge, "the image is too large");
    }
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kOutOfMemory, "the image does not fit in memory");
  }
}

Axes ras_to_lps(Axes axes) {
  for (std::size_t i = 0; i < 6; ++i) axes[i] = -axes[i];
  return axes;
}

Result<std::optional<Axes>> meta_image_axes(const std::string& path) {
  const HeaderText header(path, '=', "ElementDataFile");
  if (const auto type = header.get("ElementType"); type && !is_meta_image_type(*type)) {
    return fail(ErrorCode::kUnsupported,
                "only integers of 8 to 32 bits and floating-point voxels are supported");
  }
  const auto matrix = header.get("TransformMatrix") ? header.get("TransformMatrix")
                      : header.get("Rotation")      ? header.get("Rotation")
                                                    : header.get("Orientation");
  if (!matrix) return std::nullopt;
  const std::vector<double> m = numbers(*matrix);
  const auto spacing_text =
      header.get("ElementSpacing") ? header.get("ElementSpacing") : header.get("ElementSize");
  const std::vector<double> spacing = numbers(spacing_text.value_or("1 1 1"));
  if (m.size() != 9 || spacing.size() != 3 || !all_finite(m) || !all_finite(spacing)) {
    return fail(ErrorCode::kInvalid, "the axes of the image are invalid");
  }
  Axes axes{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // Each axis of the file is a column of the result.
    for (std::size_t row = 0; row < 3; ++row) {
      axes[3 * row + axis] = m[3 * axis + row] * std::abs(spacing[axis]);
    }
  }
  return axes;
}

Result<std::optional<Axes>> nrrd_axes(const std::string& path) {
  const HeaderText header(path, ':', "");
  const auto directions = header.get("space directions");
  const auto space = header.get("space");
  if (!directions) {
    if (space) return fail(ErrorCode::kUnsupported, "the axes of the image are missing");
    return std::nullopt;
  }
  const std::vector<double> m = numbers(*directions);
  if (m.size() != 9 || !all_finite(m)) {
    return fail(ErrorCode::kUnsupported, "only images with three spatial dimensions are supported");
  }
  Axes axes{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t row = 0; row < 3; ++row) axes[3 * row + axis] = m[3 * axis + row];
  }
  const std::string name = space.value_or("");
  if (name == "left-posterior-superior" || name == "LPS") return axes;
  if (name == "right-anterior-superior" || name == "RAS") return ras_to_lps(axes);
  if (name.empty() || name == "3D-right-handed") return axes;
  return fail(ErrorCode::kUnsupported, "only images in LPS or RAS space are supported");
}

bool meta_image_is_complete(const std::string& path, std::uint64_t bytes) {
  namespace fs = std::filesystem;
  const HeaderText header(path, '=', "ElementDataFile");
  const std::string where = header.get("ElementDataFile").value_or("LOCAL");
  std::error_code error;
  if (header.get("CompressedData") == "True") {
    const std::vector<double> packed = numbers(header.get("CompressedDataSize").value_or(""));
    if (packed.size() != 1 || !(packed[0] >= 0)) return false;
    bytes = static_cast<std::uint64_t>(packed[0]);
  }
  if (where == "LOCAL" || where == "Local" || where == "local") {
    const std::uintmax_t size = fs::file_size(path, error);
    return !error && size >= header.end() && size - header.end() >= bytes;
  }
  // The reader checks lists and patterns of files itself.
  if (where.starts_with("LIST") || where.find('%') != std::string::npos) return true;
  const std::uintmax_t size = fs::file_size(fs::path(path).parent_path() / where, error);
  return !error && size >= bytes;
}

bool nrrd_is_complete(const std::string& path, std::uint64_t bytes) {
  const HeaderText header(path, ':', "");
  if (header.get("encoding") != "raw" || header.get("data file") || header.get("datafile"))
    return true;
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  return !error && size >= header.end() && size - header.end() >= bytes;
}

Result<std::optional<PackedNrrd>> read_packed_nrrd(const std::string& path) {
  const HeaderText header(path, ':', "");
  const std::string encoding = header.get("encoding").value_or("");
  if (encoding != "gzip" && encoding != "gz") return std::nullopt;
  const auto type = voxel_type(header.get("type").value_or(""));
  const std::vector<double> sizes = numbers(header.get("sizes").value_or(""));
  if (!type || sizes.size() != 3 || header.get("endian") == "big" || header.get("data file") ||
      header.get("datafile")) {
    return fail(ErrorCode::kUnsupported,
                "compressed NRRD files must be single little-endian files with three dimensions "
                "and 8-bit, 16-bit or floating-point voxels");
  }
  PackedNrrd packed;
  packed.type = type->name;
  std::uint64_t bytes = type->bytes;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(sizes[axis] >= 1) || sizes[axis] > volume::kMaxSide) {
      return fail(ErrorCode::kTooLarge, "the image is empty or too large");
    }
    packed.size[axis] = static_cast<int>(sizes[axis]);
    bytes *= static_cast<std::uint64_t>(sizes[axis]);
  }
  const std::vector<double> spacing = numbers(header.get("spacings").value_or(""));
  for (std::size_t axis = 0; axis < 3 && spacing.size() == 3; ++axis)
    packed.spacing[axis] = spacing[axis];
  if (bytes > 8 * volume::kMaxVoxels) return fail(ErrorCode::kTooLarge, "the image is too large");
  auto voxels = unpack(path, header.end(), bytes);
  DIAPHANE_TRY(voxels);
  packed.voxels = *std::move(voxels);
  return packed;
}

}  // namespace diaphane::ingest
