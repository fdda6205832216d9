// Any bytes as a panorama. An accepted one is stored in the form that the renderer reads.
#include "scene/environment_import.h"
#include "tests/fuzz/must.h"

using namespace diaphane;

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  const std::string_view file(reinterpret_cast<const char*>(data), size);
  const auto imported = scene::import_panorama(file);
  if (!imported) {
    MUST(!scene::word_of(imported.error()).empty());
    return 0;
  }
  const auto read = scene::read_environment(scene::write_environment(*imported));
  MUST(read && read->pixels == imported->pixels);
  return 0;
}
