#include "ingest/cli/sample/dicom_series.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "common/try.h"
#include "ingest/dicom/series_writer.h"

namespace diaphane::sample {

Result<void> write_series(const volume::Volume& volume,
                          const std::function<Result<void>(const std::string& file)>& take) {
  const volume::Header& h = volume.header;
  dicom::SeriesSpec series;
  series.study_uid = dicom::new_uid();
  series.series_uid = dicom::new_uid();
  series.frame_of_reference_uid = dicom::new_uid();
  series.columns = static_cast<std::uint16_t>(h.size[0]);
  series.rows = static_cast<std::uint16_t>(h.size[1]);
  series.pixel_spacing = {h.spacing[1], h.spacing[0]};
  series.slice_thickness = h.spacing[2];
  series.orientation = {h.direction[0], h.direction[3], h.direction[6],
                        h.direction[1], h.direction[4], h.direction[7]};
  series.bits_stored = 13;  // range -1024 to 7167
  series.high_bit = 12;
  series.is_signed = 0;
  series.intercept = -1024;
  series.window_center = h.window_center;
  series.window_width = h.window_width;

  // The origin of the patient's axes is near the middle of the head, as on a scanner.
  std::array<double, 3> corner{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      corner[row] -= h.direction[3 * row + axis] * h.spacing[axis] * (h.size[axis] - 1) / 2;
    }
  }
  const std::size_t pixels = std::size_t{h.size[0]} * h.size[1];
  for (std::uint32_t n = 0; n < h.size[2]; ++n) {
    // Numbered head first, like the slices of many scanners, so that sorting by number would turn
    // the patient upside down.
    const std::uint32_t z = h.size[2] - 1 - n;
    dicom::SliceSpec slice;
    slice.instance_number = static_cast<int>(n + 1);
    for (std::size_t row = 0; row < 3; ++row) {
      slice.position[row] = corner[row] + h.direction[3 * row + 2] * h.spacing[2] * z;
    }
    slice.pixels.reserve(2 * pixels);
    for (std::size_t i = 0; i < pixels; ++i) {
      const int stored = std::clamp(volume.voxels[pixels * z + i] + 1024, 0, (1 << 13) - 1);
      slice.pixels.push_back(static_cast<std::uint8_t>(stored & 0xff));
      slice.pixels.push_back(static_cast<std::uint8_t>(stored >> 8));
    }
    auto file = dicom::write_slice(series, slice);
    DIAPHANE_TRY(file);
    if (auto ok = take(*file); !ok) return ok;
  }
  return {};
}

Result<void> write_series_folder(const volume::Volume& volume, const std::string& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) return fail(ErrorCode::kUnavailable, "cannot create the folder " + directory);
  int number = 0;
  return write_series(volume, [&](const std::string& bytes) -> Result<void> {
    char name[20];
    std::snprintf(name, sizeof name, "IM%06d",
                  ++number);  // files on a disc often have no extension
    std::ofstream out(std::filesystem::path(directory) / name, std::ios::binary | std::ios::trunc);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) return fail(ErrorCode::kUnavailable, "cannot write a file in " + directory);
    return {};
  });
}

}  // namespace diaphane::sample
