// Any bytes as a stored volume: volume.json, a zero byte, voxels.i16.
#include "volume/volume.h"

#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <string>

#include "tests/fuzz/must.h"
#include "volume/header.h"
#include "volume/store.h"

using namespace diaphane;

namespace {

/// In memory; the fuzzer runs in one thread.
const std::string& folder() {
  static const std::string made = [] {
    std::string name = "/dev/shm/diaphane-fuzz-XXXXXX";
    MUST(mkdtemp(name.data()) != nullptr);
    static const std::string kept = name;
    atexit([] {
      unlink((kept + "/volume.json").c_str());
      unlink((kept + "/voxels.i16").c_str());
      rmdir(kept.c_str());
    });
    return name;
  }();
  return made;
}

void put(const std::string& path, const unsigned char* data, std::size_t size) {
  const int fd = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  MUST(fd >= 0 && write(fd, data, size) == static_cast<ssize_t>(size) && close(fd) == 0);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  const unsigned char* end = data + size;
  const unsigned char* gap = std::find(data, end, 0);
  const std::string text(data, gap);
  if (const auto header = volume::from_json(text)) {
    MUST(volume::check(*header).has_value());
    const auto written = volume::to_json(*header);
    MUST(written.has_value());
    const auto again = volume::from_json(*written);
    MUST(again.has_value() && again->size == header->size && again->repairs == header->repairs &&
         again->phases == header->phases);
  }
  put(folder() + "/volume.json", data, text.size());
  const unsigned char* voxels = gap == end ? end : gap + 1;
  put(folder() + "/voxels.i16", voxels, static_cast<std::size_t>(end - voxels));
  const auto whole = volume::read_all_phases(folder(), size % 2 == 0);
  if (whole) {
    MUST(whole->voxels.size() == whole->header.total_voxel_count());
    MUST(whole->voxels.size() * 2 == static_cast<std::size_t>(end - voxels));
  } else {
    MUST(!whole.error().message.empty());
  }
  return 0;
}
