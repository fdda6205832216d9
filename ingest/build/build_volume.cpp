#include "ingest/build/build_volume.h"

#include <algorithm>
#include <limits>
#include <new>
#include <unordered_map>

#include "common/try.h"
#include "ingest/build/image_volume.h"
#include "ingest/build/resample.h"
#include "ingest/dicom/read_slice.h"

namespace diaphane::ingest {
namespace {

constexpr std::int32_t kLow = std::numeric_limits<std::int16_t>::min();
constexpr std::int32_t kHigh = std::numeric_limits<std::int16_t>::max();
/// Metal and the rims of detectors exceed the range of int16 in a few voxels. A larger share means
/// that the scale is wrong, and the volume would consist of clipped values.
constexpr double kLargestClippedShare = 0.1;

/// Stores the values of slices as they arrive. An MR or PT scan with 16 unsigned bits reaches
/// 65,535: from the first value above the range of int16, all of its values are halved, those
/// already stored included. Values may be negative at the same time.
class Voxels {
 public:
  Voxels(bool is_ct, volume::Volume& volume) : is_ct_(is_ct), volume_(volume) {}

  void put(const dicom::Values& values, std::size_t at) {
    padded_ += values.padded;
    if (!is_ct_ && !halved_ &&
        std::ranges::any_of(values.values, [](std::int32_t value) { return value > kHigh; })) {
      for (std::int16_t& voxel : volume_.voxels) voxel = static_cast<std::int16_t>(voxel >> 1);
      halved_ = true;
    }
    for (const std::int32_t value : values.values) {
      const std::int32_t stored = halved_ ? value >> 1 : value;
      const std::int32_t kept = std::clamp(stored, kLow, kHigh);
      clamped_ += kept != stored ? 1 : 0;
      volume_.voxels[at++] = static_cast<std::int16_t>(kept);
    }
  }

  std::uint64_t padded() const { return padded_; }

  /// Lists what was changed among the repairs. Returns kUnsupported if too many values were
  /// clipped.
  Result<void> settle() const {
    if (static_cast<double>(clamped_) >
        kLargestClippedShare * static_cast<double>(volume_.voxels.size())) {
      return fail(ErrorCode::kUnsupported,
                  "many of its values are too large to store, so the scale in the files is wrong");
    }
    std::vector<std::string>& repairs = volume_.header.repairs;
    if (clamped_ > 0) {
      repairs.emplace_back(is_ct_ ? "values above 32,767 Hounsfield units were clipped"
                                  : "values above 65,535 were clipped");
    }
    if (halved_) repairs.emplace_back("values were halved for storage");
    return {};
  }

 private:
  bool is_ct_, halved_ = false;
  volume::Volume& volume_;
  std::size_t clamped_ = 0;
  std::uint64_t padded_ = 0;
};

volume::Header header_of(const dicom::Assessment& found, const dicom::Choice& choice) {
  volume::Header header;
  header.spacing = found.spacing;
  header.direction = found.direction;
  header.modality = found.modality;
  header.window_center = found.window_center;
  header.window_width = found.window_width;
  header.origin = found.origin;
  header.repairs = choice.repairs;
  header.phases = found.phases;
  return header;
}

}  // namespace

Result<Built> build_volume(dicom::FileSource& source, const dicom::Scan& scan,
                           const dicom::Choice& choice, const dicom::Limits& limits) {
  const dicom::Series& series = scan.series[choice.index];
  const dicom::Assessment& found = series.assessment;
  // The z of the slices by file. The slices of later phases follow those of the first one.
  std::unordered_map<std::size_t, std::vector<std::size_t>> places;
  for (std::size_t z = 0; z < found.order.size(); ++z) {
    places[series.slices[found.order[z]].file].push_back(z);
  }
  Built built;
  volume::Volume& volume = built.volume;
  volume.header = header_of(found, choice);
  const dicom::Slice& first = series.slices[found.order.front()];
  volume.header.frame_of_reference = first.frame_of_reference;
  volume.header.size = {
      first.columns, first.rows,
      static_cast<std::uint32_t>(found.order.size() / volume.header.phase_count())};
  try {
    volume.voxels.resize(volume.header.total_voxel_count());
    Voxels voxels(found.modality == volume::Modality::kCt, volume);
    const std::size_t picture = std::size_t{first.columns} * first.rows;
    std::size_t done = 0;
    const auto want = [&](std::size_t file) { return places.contains(file); };
    const auto take = [&](std::size_t file, dicom::FileSource::Bytes bytes) -> Result<void> {
      const dicom::Precheck checked = dicom::precheck(bytes, limits);
      if (checked.state != dicom::FileState::kFit)
        return fail(ErrorCode::kInvalid, "a file has changed during processing");
      for (const std::size_t z : places[file]) {
        auto values = dicom::read_values(checked, series.slices[found.order[z]], found.unit);
        DIAPHANE_TRY(values);
        voxels.put(*values, z * picture);
        ++done;
      }
      return {};
    };
    DIAPHANE_TRY(source.visit(want, take));
    if (done != found.order.size())
      return fail(ErrorCode::kInvalid, "a file has disappeared during processing");
    DIAPHANE_TRY(voxels.settle());
    const auto air = static_cast<std::int16_t>(dicom::air_of(found.modality));
    built.filler = {air, voxels.padded()};
    if (!found.sources.empty()) resample(found, air, built);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kOutOfMemory, "the volume needs more memory than allowed");
  }
  volume::measure(volume, built.filler);
  return built;
}

}  // namespace diaphane::ingest
