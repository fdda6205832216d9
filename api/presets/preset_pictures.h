#pragma once

#include <functional>
#include <string>

#include "api/presets/presets.h"
#include "api/scans/data_sets.h"
#include "api/shared/placement.h"

namespace diaphane::api {

/// Renders a thumbnail for each preset, which shows its data set with the preset applied. The
/// thumbnails are rendered in the background, one at a time. The file `<cache
/// directory>/presets/<preset>/picture.jpg` is kept until the preset changes or is deleted, or the
/// data set is anonymised (migrations/0008). The work is not charged to any user. Thread-safe.
class PresetPictures {
 public:
  /// `scene_bytes` serialises a preset's scene, or returns an empty string if it cannot be parsed.
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

  /// Returns the path below the cache directory if the user may read the preset. Returns kNotFound
  /// also while there is no thumbnail yet.
  Outcome<std::string> get(const Principal& who, const std::string& data_set_id,
                           const std::string& preset_id);
  /// Renders the next thumbnail, which takes seconds. Returns false if none is due or no worker is
  /// available.
  bool make_next();
  /// Deletes the file of the thumbnail.
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
