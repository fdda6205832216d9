#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"
#include "volume/volume.h"

namespace diaphane::sample {

/// Where Debian's invesalius-examples puts it.
inline constexpr const char* kCraniumPath =
    "/usr/share/doc/invesalius-examples/examples/Cranium.inv3";

/// The matrix of InVesalius' project, exactly as it is stored: int16 Hounsfield units, x fastest.
///
/// Its axes: InVesalius turns each DICOM slice upside down as it copies it into the matrix and
/// leaves the columns as they are (invesalius/data/imagedata_utils.py, dcm2memmap: `matrix[n] =
/// slice[::-1]`); it sorts axial slices by position along the normal, feet first (dicom_grouper.py,
/// GetFilenameList). So of a head scanned supine, with rows to the patient's left and columns to
/// the back,
///   x rises to the patient's left, y rises to the FRONT, z rises to the head: a left-handed frame.
/// What a picture can show of this was checked by eye: the nose is at high y, the head rest at low
/// y, the vertex at high z. Left and right look alike; they follow from the columns' not being
/// touched, and from that a scanner's frame is right-handed.
struct Cranium {
  std::array<std::uint32_t, 3> size{256, 256, 108};
  std::array<double, 3> spacing{0.957031, 0.957031, 1.5};  ///< mm (main.plist says 0.9570312)
  std::vector<std::int16_t> matrix;
};

/// kNotFound when the file is absent (with the package to install), kInvalid when it is not the
/// project.
Result<Cranium> read_cranium(const std::string& path);

/// The matrix as a right-handed volume in the patient's axes (x left, y back, z head): y turned
/// back.
volume::Volume upright(const Cranium& cranium);

/// The volume of the renderers' comparison (scenes, "cranium"): the matrix's own order of axes, not
/// turned, values round(30000 clamp((HU - 150)/450, 0, 1)), axes taken as x, y, z. For figures
/// only: seen as a patient it is mirrored.
volume::Volume mapped(const Cranium& cranium);

/// `volume` as a MetaImage with its voxels in the same file. kUnavailable when it cannot be
/// written.
Result<void> write_mha(const volume::Volume& volume, const std::string& path);

}  // namespace diaphane::sample
