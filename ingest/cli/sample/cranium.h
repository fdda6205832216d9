#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::sample {

/// Installed by Debian's package invesalius-examples.
inline constexpr const char* kCraniumPath =
    "/usr/share/doc/invesalius-examples/examples/Cranium.inv3";

/// The matrix of an InVesalius project exactly as stored: int16 Hounsfield units, x fastest.
/// InVesalius flips each DICOM slice vertically as it copies it into the matrix and leaves the
/// columns unchanged (invesalius/data/imagedata_utils.py, dcm2memmap: `matrix[n] = slice[::-1]`).
/// It sorts axial slices by position along the normal, feet first (dicom_grouper.py,
/// GetFilenameList). For a head scanned supine, with rows to the patient's left and columns to the
/// back, x therefore rises to the patient's left, y to the FRONT and z to the head, which is a
/// left-handed frame. A visual check confirmed what a picture can show: the nose is at high y, the
/// head rest at low y and the vertex at high z. Left and right look alike. They follow from the
/// unchanged columns and from a scanner's frame being right-handed.
struct Cranium {
  std::array<std::uint32_t, 3> size{256, 256, 108};
  std::array<double, 3> spacing{0.957031, 0.957031, 1.5};  ///< mm (main.plist says 0.9570312)
  std::vector<std::int16_t> matrix;
};

/// Reads the project. Returns kNotFound with the package to install if the file does not exist, and
/// kInvalid if it is not the project.
Result<Cranium> read_cranium(const std::string& path);

/// Converts the matrix to a right-handed volume in the patient's axes (x left, y back, z head) by
/// reversing y.
volume::Volume upright(const Cranium& cranium);

/// Returns the volume for comparisons with other renderers (scene "cranium"). It keeps the matrix's
/// order of axes, read as x, y, z, and has the values round(30000 clamp((HU - 150)/450, 0, 1)). It
/// mirrors the patient, so use it for measurements only.
volume::Volume mapped(const Cranium& cranium);

/// Writes `volume` as a MetaImage with its voxels in the same file. Returns kUnavailable on
/// failure.
Result<void> write_mha(const volume::Volume& volume, const std::string& path);

}  // namespace diaphane::sample
