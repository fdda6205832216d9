#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include "common/try.h"
#include "ingest/build/nifti.h"
#include "ingest/labels/read_labels.h"

namespace diaphane::ingest {
namespace {

using Bytes = std::span<const std::byte>;

/// Reads voxels of one type as numbers.
template <typename T>
class Voxels {
 public:
  Voxels(Bytes bytes, const NiftiHeader& header) : bytes_(bytes), header_(header) {}

  std::size_t size() const { return bytes_.size() / sizeof(T); }
  double operator[](std::size_t i) const {
    std::array<std::byte, sizeof(T)> one{};
    std::memcpy(one.data(), bytes_.data() + i * sizeof(T), sizeof(T));
    if (header_.swapped) std::reverse(one.begin(), one.end());
    T value;
    std::memcpy(&value, one.data(), sizeof(T));
    return header_.slope * static_cast<double>(value) + header_.intercept;
  }

 private:
  Bytes bytes_;
  const NiftiHeader& header_;
};

/// Collects the distinct numbers in the label table, in ascending order.
template <typename T>
Result<void> take_labels(const Voxels<T>& voxels, LabelImage& image) {
  std::map<std::uint32_t, std::uint8_t> known;
  constexpr double kLargest = 4294967295.0;
  double last = 0;
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const double value = voxels[i];
    if (value == last) continue;
    // The negated comparison also rejects NaN.
    if (!(value >= 0 && value <= kLargest && value == std::floor(value))) {
      return fail(
          ErrorCode::kInvalid,
          "This is not a label volume: its voxels must be whole numbers that are not negative.");
    }
    last = value;
    if (value == 0) continue;
    known.emplace(static_cast<std::uint32_t>(value), std::uint8_t{0});
    if (known.size() > volume::kMostLabels) {
      return fail(ErrorCode::kTooLarge,
                  "The file has more than 255 different labels. Is it a scan instead?");
    }
  }
  if (known.empty()) return fail(ErrorCode::kInvalid, "The file contains no labels.");
  for (auto& [number, place] : known) {
    place = static_cast<std::uint8_t>(image.table.size() + 1);
    image.table.push_back({number, {}, volume::label_colour(image.table.size())});
  }
  image.voxels.resize(voxels.size());
  std::uint8_t place = 0;
  last = 0;
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const double value = voxels[i];
    if (value != last) {
      place = value == 0 ? std::uint8_t{0} : known.at(static_cast<std::uint32_t>(value));
      last = value;
    }
    image.voxels[i] = place;
  }
  return {};
}

Result<void> take_labels_of(Bytes voxels, const NiftiHeader& header, LabelImage& image) {
  switch (header.type) {
    case VoxelType::kUint8:
      return take_labels(Voxels<std::uint8_t>(voxels, header), image);
    case VoxelType::kInt8:
      return take_labels(Voxels<std::int8_t>(voxels, header), image);
    case VoxelType::kUint16:
      return take_labels(Voxels<std::uint16_t>(voxels, header), image);
    case VoxelType::kInt16:
      return take_labels(Voxels<std::int16_t>(voxels, header), image);
    case VoxelType::kUint32:
      return take_labels(Voxels<std::uint32_t>(voxels, header), image);
    case VoxelType::kInt32:
      return take_labels(Voxels<std::int32_t>(voxels, header), image);
    case VoxelType::kFloat:
      return take_labels(Voxels<float>(voxels, header), image);
    case VoxelType::kDouble:
      break;
  }
  return take_labels(Voxels<double>(voxels, header), image);
}

}  // namespace

Result<LabelImage> read_nifti_labels(Bytes file, const LabelLimits& limits) {
  const auto header = read_nifti_header(file);
  DIAPHANE_TRY(header);
  if (!header->phases.empty()) {
    return fail(ErrorCode::kUnsupported, "labels apply to all phases, so their file has only one");
  }
  const auto& size = header->size;
  const std::uint64_t count = std::uint64_t{size[0]} * size[1] * size[2];
  if (count > limits.voxels) {
    return fail(ErrorCode::kTooLarge, "The label volume has more voxels than allowed.");
  }
  LabelImage image;
  image.size = size;
  image.axes = header->axes;
  image.origin = header->origin;
  DIAPHANE_TRY(
      take_labels_of(file.subspan(header->voxels_begin, header->voxels_bytes()), *header, image));
  return image;
}

}  // namespace diaphane::ingest
