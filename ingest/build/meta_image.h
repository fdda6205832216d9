#pragma once

#include <string>

#include "ingest/build/image_header.h"

namespace diaphane::ingest {

/// Reads a MetaImage of three dimensions, or of four with the phases last, and the files that it
/// names, with the library of the format. The format has no unit of time, so phases have numbers.
/// Returns the errors of read_nrrd().
Result<Image> read_meta_image(const std::string& path);

}  // namespace diaphane::ingest
