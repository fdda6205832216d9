#pragma once

#include <functional>
#include <string>

#include "api/service/data_sets.h"
#include "api/service/placement.h"
#include "api/service/presets.h"

namespace diaphane::api {

/// A small picture of each preset: the data set that it was saved for, as it shows it. Made in the
/// background, one after the other, and kept in `<cache directory>/presets/<preset>/picture.jpg`
/// until the preset changes or goes, or the data set is cut (migrations/0008). The system's own
/// work: nobody's render time. Thread-safe.
class PresetPictures {
 public:
  /// The estimated error that a picture is rendered to. A device that is busy with sessions may
  /// take too long for it: then the picture is what it was after kPatience.
  static constexpr double kError = 0.02;
  static constexpr std::uint32_t kMostSamples = 1024;  ///< per pixel
  static constexpr std::uint32_t kSize = 320;          ///< pixels, of both sides

  /// `scene_bytes` makes a serialised Scene of a preset's; empty when it cannot be read.
  PresetPictures(DataSets& data_sets, Presets& presets, PresetStore& store, Stills& stills,
                 const Clock& clock, std::string cache_directory,
                 std::function<std::string(const std::string& scene)> scene_bytes)
      : data_sets_(data_sets),
        presets_(presets),
        store_(store),
        stills_(stills),
        clock_(clock),
        directory_(std::move(cache_directory)),
        scene_bytes_(std::move(scene_bytes)) {}

  /// The file's path below the cache directory, for whoever may read the preset. kNotFound: also
  /// while there is none yet.
  Outcome<std::string> get(const Principal& who, const std::string& data_set_id,
                           const std::string& preset_id);
  /// Makes the next picture, which takes seconds; false when there is none to be made now, or
  /// nobody to make it.
  bool make_next();
  /// Forgets the picture's file.
  Result<void> remove(const std::string& preset_id);

 private:
  DataSets& data_sets_;
  Presets& presets_;
  PresetStore& store_;
  Stills& stills_;
  const Clock& clock_;
  const std::string directory_;
  const std::function<std::string(const std::string&)> scene_bytes_;
};

}  // namespace diaphane::api
