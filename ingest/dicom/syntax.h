#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace diaphane::dicom {

/// How the pixels of a transfer syntax are packed.
enum class Packing { kNative, kRle, kJpeg, kJpegLs, kJpeg2000 };

struct TransferSyntax {
  std::string_view uid;
  Packing packing = Packing::kNative;
  bool explicit_vr = true;
  bool big_endian = false;
  bool deflated = false;
  bool lossy = false;  ///< allows lossy compression
};

/// Returns a supported syntax (DICOM PS3.5, annex A), or nullopt for any other.
std::optional<TransferSyntax> find_syntax(std::string_view uid);

/// Returns a well-known name such as "MPEG2" or "HTJ2K", or the UID itself if it is unknown but
/// well-formed.
std::string syntax_name(std::string_view uid);

}  // namespace diaphane::dicom
