// Any bytes as a compressed image. The first byte chooses the syntax, and the next four the claimed
// size.
#include "ingest/dicom/codestream.h"

#include <array>

#include "tests/fuzz/must.h"

using namespace diaphane::dicom;

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  constexpr std::array<const char*, 7> kWays{"1.2.840.10008.1.2.5",    "1.2.840.10008.1.2.4.50",
                                             "1.2.840.10008.1.2.4.51", "1.2.840.10008.1.2.4.70",
                                             "1.2.840.10008.1.2.4.80", "1.2.840.10008.1.2.4.90",
                                             "1.2.840.10008.1.2"};
  if (size < 6) return 0;
  const auto syntax = find_syntax(kWays[data[0] % kWays.size()]);
  MUST(syntax.has_value());
  const PictureClaim claim{data[1] * 256u + data[2], data[3] * 256u + data[4], 1u + data[5] / 128u,
                           data[5] % 2 == 0 ? 16u : 8u};
  const auto fault = fault_of(std::as_bytes(std::span(data + 6, size - 6)), *syntax, claim);
  MUST(!fault || !fault->empty());
  MUST(fault || syntax->packing != Packing::kNative);
  return 0;
}
