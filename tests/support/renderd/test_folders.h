#pragma once

// Folders of the checkout that tests read. Their paths are compiled in one small file, because
// other checkouts do not find an object with a path of this one in ccache.

namespace diaphane::render::test {

extern const char* const kDocs;    ///< docs
extern const char* const kScenes;  ///< tests/scenes

}  // namespace diaphane::render::test
