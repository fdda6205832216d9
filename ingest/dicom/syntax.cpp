#include "ingest/dicom/syntax.h"

#include <algorithm>
#include <array>

namespace diaphane::dicom {
namespace {

constexpr std::array<TransferSyntax, 13> kRead{{
    {"1.2.840.10008.1.2", Packing::kNative, false, false, false},
    {"1.2.840.10008.1.2.1", Packing::kNative, true, false, false},
    {"1.2.840.10008.1.2.1.99", Packing::kNative, true, false, true},
    {"1.2.840.10008.1.2.2", Packing::kNative, true, true, false},
    {"1.2.840.10008.1.2.5", Packing::kRle, true, false, false},
    {"1.2.840.10008.1.2.4.50", Packing::kJpeg, true, false, false, true},
    {"1.2.840.10008.1.2.4.51", Packing::kJpeg, true, false, false, true},
    {"1.2.840.10008.1.2.4.57", Packing::kJpeg, true, false, false},
    {"1.2.840.10008.1.2.4.70", Packing::kJpeg, true, false, false},
    {"1.2.840.10008.1.2.4.80", Packing::kJpegLs, true, false, false},
    {"1.2.840.10008.1.2.4.81", Packing::kJpegLs, true, false, false, true},
    {"1.2.840.10008.1.2.4.90", Packing::kJpeg2000, true, false, false},
    {"1.2.840.10008.1.2.4.91", Packing::kJpeg2000, true, false, false, true},
}};

struct Named {
  std::string_view prefix;
  std::string_view name;
};
constexpr std::array<Named, 7> kNames{{
    {"1.2.840.10008.1.2.4.100", "MPEG-2 video"},
    {"1.2.840.10008.1.2.4.101", "MPEG-2 video"},
    {"1.2.840.10008.1.2.4.102", "MPEG-4 video"},
    {"1.2.840.10008.1.2.4.107", "HEVC video"},
    {"1.2.840.10008.1.2.4.94", "JPIP"},
    {"1.2.840.10008.1.2.4.95", "JPIP"},
    {"1.2.840.10008.1.2.4.20", "high-throughput JPEG 2000"},
}};

}  // namespace

std::optional<TransferSyntax> find_syntax(std::string_view uid) {
  const auto found = std::find_if(kRead.begin(), kRead.end(),
                                  [&](const TransferSyntax& syntax) { return syntax.uid == uid; });
  if (found == kRead.end()) return std::nullopt;
  return *found;
}

std::string syntax_name(std::string_view uid) {
  for (const Named& named : kNames) {
    if (uid.starts_with(named.prefix)) return std::string(named.name);
  }
  // A UID consists of digits and dots. Anything else is text from the file and is not repeated.
  const bool plain = !uid.empty() && uid.size() <= 64 &&
                     uid.find_first_not_of("0123456789.") == std::string_view::npos &&
                     uid.starts_with("1.2.840.10008.");
  return plain ? std::string(uid) : "unknown type";
}

}  // namespace diaphane::dicom
