// Any bytes as an upload.
#include <sys/mman.h>
#include <unistd.h>

#include <vector>

#include "ingest/pipeline/tar_source.h"
#include "tests/fuzz/must.h"

using namespace diaphane;

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  static const int fd = memfd_create("upload", MFD_CLOEXEC);
  MUST(ftruncate(fd, 0) == 0 && lseek(fd, 0, SEEK_SET) == 0);
  MUST(write(fd, data, size) == static_cast<ssize_t>(size));
  ingest::TarSource source(fd, 1 << 16);
  std::vector<std::size_t> sizes;
  std::size_t together = 0;
  const auto first = source.visit([](std::size_t) { return true; },
                                  [&](std::size_t, dicom::FileSource::Bytes bytes) -> Result<void> {
                                    together += bytes.size();
                                    sizes.push_back(bytes.size());
                                    return {};
                                  });
  MUST(together <= size);
  // A second visit gives the same result, and unwanted files are skipped.
  std::size_t n = 0;
  const auto again = source.visit([](std::size_t index) { return index % 2 == 0; },
                                  [&](std::size_t index, dicom::FileSource::Bytes) -> Result<void> {
                                    MUST(index % 2 == 0);
                                    ++n;
                                    return {};
                                  });
  MUST(n <= sizes.size());
  MUST(!first || again.has_value());
  return 0;
}
