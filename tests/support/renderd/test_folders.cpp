#include "tests/support/renderd/test_folders.h"

namespace diaphane::render::test {

const char* const kDocs = DIAPHANE_DOCS;
const char* const kScenes = DIAPHANE_SCENES;

}  // namespace diaphane::render::test
