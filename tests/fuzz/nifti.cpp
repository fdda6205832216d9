// Any bytes as a scan in NIfTI. An accepted header keeps its voxels within the file.
#include "ingest/build/nifti.h"

#include "tests/fuzz/must.h"

using namespace diaphane;

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  const auto file = std::as_bytes(std::span(data, size));
  const auto header = ingest::read_nifti_header(file);
  if (!header) {
    MUST(!header.error().message.empty());
    return 0;
  }
  const std::uint64_t bytes = header->voxels_bytes();
  MUST(bytes > 0 && header->voxels_begin >= 348 && header->voxels_begin + bytes <= size);
  return 0;
}
