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
  bool lossy = false;  ///< may lose something
};

/// The syntaxes that are read (DICOM PS3.5, annex A); nothing for any other.
std::optional<TransferSyntax> find_syntax(std::string_view uid);

/// What a person may have heard of: "MPEG2", "HTJ2K"; the UID itself if it is unknown but
/// well-formed.
std::string syntax_name(std::string_view uid);

}  // namespace diaphane::dicom
