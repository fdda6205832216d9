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
  bool shown = true;    ///< when the scan is opened
  bool shared = false;  ///< everyone who may view the scan sees it
  bool mine = false;    ///< of the requesting user
  Time created_at, updated_at;
};

/// Absent fields stay unchanged.
struct AnnotationChange {
  std::optional<std::string> name, content;
  std::optional<bool> shown, shared;
  /// The revision of the content that the change is based on. Any if absent.
  std::optional<std::string> revision;
};

/// Names a content, so that a change based on an older one can be refused.
std::string revision_of(const AnnotationSet& set);

/// Implemented by annotations/annotation_repository. Every function may return kUnavailable. The
/// caller checks permissions first.
class AnnotationStore {
 public:
  virtual ~AnnotationStore() = default;
  /// Those of the viewer and the shared ones, oldest first.
  virtual Result<std::vector<AnnotationSet>> list(const std::string& data_set_id,
                                                  const std::string& viewer_id) = 0;
  /// Returns kTooMany if the author would have more than `most` of this data set.
  virtual Result<void> add(const AnnotationSet& set, int most) = 0;
  /// Return kNotFound also for a set of another author. A change with a revision returns kConflict
  /// if the stored content is not that of `set`.
  virtual Result<void> change(const AnnotationSet& set, const AnnotationChange& what, Time now) = 0;
  virtual Result<void> remove(const AnnotationSet& set) = 0;
};

/// The saved marks and measurements of scans. Everyone who may save presets may save some for
/// themselves. Only the owner of the scan can share theirs, with everyone who may view the scan.
/// Contents are validated before they get here (scene/annotations.h). Thread-safe.
class AnnotationSets {
 public:
  static constexpr int kMostSets = 20;  ///< per author and scan

  AnnotationSets(DataSets& data_sets, AnnotationStore& store, const Clock& clock)
      : data_sets_(data_sets), store_(store), clock_(clock) {}

  Outcome<std::vector<AnnotationSet>> list(const Principal& who, const std::string& data_set_id);
  /// Those that the owner shares, for a visitor with a link. The caller checks the link.
  Outcome<std::vector<AnnotationSet>> shared_of(const std::string& data_set_id);
  /// Uses name, content, shown and shared of `set`. kTooMany.
  Outcome<AnnotationSet> add(const Principal& who, const std::string& data_set_id,
                             AnnotationSet set);
  /// kPrecondition if the content has another revision than the change is based on.
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
