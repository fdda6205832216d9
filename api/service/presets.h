#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/service/data_sets.h"
#include "common/clock.h"

namespace diaphane::api {

struct Preset {
  std::string id, data_set_id;
  std::string author_id, author_name;  ///< the name is the public one, or empty
  std::string name;
  int version = 1;  ///< rises with each change
  int votes = 0;    ///< for it less against it
  int my_vote = 0;  ///< -1, 0, 1
  bool is_default = false;
  bool mine = false;  ///< of the one who asked
  Time created_at, updated_at;
  std::string scene;     ///< Protobuf JSON of a checked Scene; empty in lists
  std::string kept_xml;  ///< the document it was read from, when it holds more than the scene
};

/// Absent: stays.
struct PresetChange {
  std::optional<std::string> name, scene;
};

/// Implemented by postgres/preset_repository. Every function: kUnavailable. Each is one
/// transaction. Whether somebody may is asked before (access.h).
class PresetStore {
 public:
  struct Limits {
    int of_author = 20;  ///< in one data set
    int of_data_set = 500;
  };
  virtual ~PresetStore() = default;

  /// The default first, then by votes, then the oldest first.
  virtual Result<std::vector<Preset>> list(const std::string& data_set_id,
                                           const std::string& viewer_id) = 0;
  /// kNotFound.
  virtual Result<Preset> find(const std::string& id, const std::string& viewer_id) = 0;
  /// kTooMany.
  virtual Result<void> add(const Preset& preset, const Limits& limits) = 0;
  /// kNotFound; kConflict when it is of another version by now.
  virtual Result<void> change(const std::string& id, int version, const PresetChange& what,
                              Time now) = 0;
  virtual Result<void> remove(const std::string& id, int version) = 0;
  /// `value` 0 takes it back.
  virtual Result<void> vote(const std::string& id, const std::string& user_id, int value) = 0;
  /// `preset_id` empty: none. kNotFound unless it is one of that data set.
  virtual Result<void> set_default(const std::string& data_set_id,
                                   const std::string& preset_id) = 0;
};

/// Presets of data sets. A scene is checked before it comes here (handlers/preset_format.h).
/// Thread-safe.
class Presets {
 public:
  Presets(DataSets& data_sets, PresetStore& store, const Clock& clock)
      : data_sets_(data_sets), store_(store), clock_(clock) {}

  Outcome<std::vector<Preset>> list(const Principal& who, const std::string& data_set_id);
  Outcome<Preset> find(const Principal& who, const std::string& id);
  /// `preset`: name, scene, kept_xml. kTooMany.
  Outcome<Preset> add(const Principal& who, const std::string& data_set_id, Preset preset);
  /// By its author. kPrecondition: `version` is not what it is now.
  Outcome<Preset> change(const Principal& who, const std::string& id, int version,
                         const PresetChange& what);
  /// By its author, the owner of the data set, or an administrator.
  Outcome<void> remove(const Principal& who, const std::string& id, int version);
  Outcome<Preset> vote(const Principal& who, const std::string& id, int value);
  Outcome<void> set_default(const Principal& who, const std::string& data_set_id,
                            const std::string& preset_id);

 private:
  DataSets& data_sets_;
  PresetStore& store_;
  const Clock& clock_;
};

}  // namespace diaphane::api
