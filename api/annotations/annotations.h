#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/scans/data_sets.h"
#include "common/clock.h"

namespace diaphane::api {

/// Marks and measurements that a user saved with a scan under one name.
struct AnnotationSet {
  std::string id, data_set_id, author_id;
  std::string name;
  std::string content;  ///< Protobuf JSON of checked Annotations
  bool shown = true;    ///< visible when the scan is opened
  bool shared = false;  ///< visible to everyone who may view the scan
  bool mine = false;    ///< belongs to the requesting user
  Time created_at, updated_at;
};

/// Changes of a set. Absent fields stay unchanged.
struct AnnotationChange {
  std::optional<std::string> name, content;
  std::optional<bool> shown, shared;
  /// The revision of the content that the change is based on. If absent, any revision is accepted.
  std::optional<std::string> revision;
};

/// Returns a hash of the content, so that a change based on older content can be refused.
std::string revision_of(const AnnotationSet& set);

/// Implemented by annotations/annotation_repository. Every function may return kUnavailable. The
/// caller checks permissions first.
class AnnotationStore {
 public:
  virtual ~AnnotationStore() = default;
  /// Returns the viewer's own sets and the shared ones of a data set, oldest first.
  virtual Result<std::vector<AnnotationSet>> list(const std::string& data_set_id,
                                                  const std::string& viewer_id) = 0;
  /// Returns kTooMany if the author would have more than `most` sets for this data set.
  virtual Result<void> add(const AnnotationSet& set, int most) = 0;
  /// Both functions return kNotFound also for a set of another author. A change with a revision
  /// returns kConflict if the stored content is not that of `set`.
  virtual Result<void> change(const AnnotationSet& set, const AnnotationChange& what, Time now) = 0;
  virtual Result<void> remove(const AnnotationSet& set) = 0;
};

/// The saved marks and measurements of scans. Everyone who may save presets may save marks for
/// themselves. Only the owner of the scan can share them with everyone who may view the scan. The
/// caller validates the contents (scene/annotations.h). Thread-safe.
class AnnotationSets {
 public:
  static constexpr int kMostSets = 20;  ///< per author and scan

  AnnotationSets(DataSets& data_sets, AnnotationStore& store, const Clock& clock)
      : data_sets_(data_sets), store_(store), clock_(clock) {}

  Outcome<std::vector<AnnotationSet>> list(const Principal& who, const std::string& data_set_id);
  /// Returns the sets that the owner shares, for a visitor with a link. The caller checks the link.
  Outcome<std::vector<AnnotationSet>> shared_of(const std::string& data_set_id);
  /// Saves the name, content, shown and shared of `set`. Returns kTooMany at kMostSets.
  Outcome<AnnotationSet> add(const Principal& who, const std::string& data_set_id,
                             AnnotationSet set);
  /// Returns kPrecondition if the content no longer has the revision that the change is based on.
  Outcome<AnnotationSet> change(const Principal& who, const std::string& data_set_id,
                                const std::string& id, const AnnotationChange& what);
  Outcome<void> remove(const Principal& who, const std::string& data_set_id, const std::string& id);

 private:
  Outcome<AnnotationSet> find_own(const Principal& who, const std::string& data_set_id,
                                  const std::string& id);

  DataSets& data_sets_;
  AnnotationStore& store_;
  const Clock& clock_;
};

}  // namespace diaphane::api
