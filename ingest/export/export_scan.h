#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/result.h"
#include "ingest/export/sink.h"
#include "ingest/export/surface.h"
#include "volume/volume.h"

namespace diaphane::ingest {

enum class ExportFormat { kNifti, kNiftiGz, kStl, kGlb };

/// Returns the format of a file name: .nii, .nii.gz, .stl or .glb.
std::optional<ExportFormat> export_format_of(std::string_view name);

/// The file to write for a scan. A surface needs exactly one of `label` and `above`, and NIfTI
/// neither.
struct ExportOrder {
  ExportFormat format = ExportFormat::kNiftiGz;
  std::optional<std::uint32_t> label;  ///< number of a label (LabelEntry::number)
  std::optional<std::int32_t> above;   ///< smallest value of an enclosed voxel
  std::uint32_t phase = 0;             ///< of the scan, for `above`
};

/// Writes the file. NIfTI needs a volume with all phases, and a surface one with a single phase.
/// Returns kInvalid with what is wrong with the order, the errors of write_nifti()
/// and make_surface(), or those of `sink`.
Result<void> export_scan(const volume::Volume& volume, const ExportOrder& order,
                         const SurfaceLimits& limits, const Sink& sink);

}  // namespace diaphane::ingest
