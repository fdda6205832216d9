// Any bytes as a DICOM file: the pre-check, the walk over elements, inflating, compressed images.
#include "ingest/dicom/precheck.h"

#include <algorithm>
#include <vector>

#include "tests/fuzz/must.h"

using namespace diaphane::dicom;

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  Limits limits;
  limits.file_bytes = 1 << 20;
  limits.pixel_bytes = limits.frame_bytes = 1 << 18;
  limits.inflated_bytes = 1 << 18;
  limits.inflated_free = 1 << 16;
  limits.elements = 2000;
  const Precheck checked = precheck(std::as_bytes(std::span(data, size)), limits);
  if (checked.state != FileState::kFit) {
    MUST(!checked.text.empty() && checked.text.size() < 200);
    MUST(checked.plain.empty());
    // The project's own words or a registered identifier, never text of the file.
    MUST(std::all_of(checked.text.begin(), checked.text.end(),
                     [](char c) { return c >= ' ' && c <= '~'; }));
    return 0;
  }
  MUST(std::uint64_t{checked.rows} * checked.columns * checked.frames <= limits.pixel_bytes);
  MUST(checked.plain.size() <= std::max<std::uint64_t>(size, limits.inflated_bytes) + 512);
  MUST(checked.has_pixels == !checked.pixels.empty());
  MUST(checked.unpacked_bytes <= std::max(limits.inflated_bytes, limits.pixel_bytes));
  // The pre-check finds the same in the file that it hands on.
  const Precheck again = precheck(checked.plain, limits);
  MUST(again.state == FileState::kFit);
  MUST(again.rows == checked.rows && again.columns == checked.columns);
  MUST(again.frames == checked.frames && !again.has_pixels);
  MUST(again.plain == checked.plain);
  if (!checked.has_pixels || checked.frames == 0) return 0;
  for (const std::uint64_t frame : {std::uint64_t{0}, checked.frames - 1}) {
    const std::vector<std::byte> one = frame_file(checked, frame);
    if (one.empty()) continue;
    const Precheck alone = precheck(one, limits);
    MUST(alone.state == FileState::kFit && alone.frames == 1);
    MUST(frame_file(alone, 0) == one);
  }
  return 0;
}
