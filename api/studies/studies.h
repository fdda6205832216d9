#pragma once

#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "api/accounts/accounts.h"
#include "api/scans/data_sets.h"
#include "api/shared/idempotency.h"
#include "api/shared/placement.h"
#include "api/shared/problem.h"
#include "api/studies/study_export.h"
#include "api/studies/study_store.h"
#include "common/clock.h"

namespace diaphane::api {

/// Calculates the results of a study from its export. Implemented by studies/analysis_client.
class StudyAnalysis {
 public:
  virtual ~StudyAnalysis() = default;
  /// Returns the service's JSON document, or kUnavailable if there is no service or it fails.
  virtual Result<std::string> analyse(const std::string& export_path,
                                      const std::string& language) = 0;
};

struct CheckedPicture {
  std::string type;   ///< "image/jpeg" or "image/png"
  std::string bytes;  ///< without metadata
};
using CheckPicture = std::function<Result<CheckedPicture>(std::string_view file)>;

/// Returns the data set if a study of this researcher may show it: their own, a public one or a
/// sample. Returns kNotFound, kNotReady or kForbidden.
Outcome<DataSet> find_for_study(DataSets& data_sets, const std::string& owner_id,
                                const std::string& id);

/// The studies of researchers. The request router checks the role. Thread-safe.
class Studies {
 public:
  static constexpr int kMostStudies = 100;  ///< per researcher
  static constexpr int kMostAnalyses = 2;   ///< at the same time
  static constexpr std::size_t kMostTourViews = 64;
  static constexpr std::chrono::hours kPreviewLife{24};

  struct Page {
    std::vector<Study> items;
    std::optional<Cursor> next;
  };
  /// A file below the cache directory, which the edge sends.
  struct File {
    std::string name;  ///< relative to the cache directory
    std::string content_type;
  };

  struct Tour {
    std::string document;    ///< JSON, or empty if the scan has no tour of a study
    bool removable = false;  ///< by the requesting user
  };

  Studies(StudyStore& store, DataSets& data_sets, Placement& placement, StudyAnalysis& analysis,
          StudyExports& exports, CheckPicture check_picture, const Clock& clock)
      : store_(store),
        data_sets_(data_sets),
        placement_(placement),
        analysis_(analysis),
        exports_(exports),
        check_picture_(std::move(check_picture)),
        clock_(clock) {}

  Outcome<Study> create(const Principal& who, StudyContent content, const std::string& key);
  Outcome<Page> list(const Principal& who, const std::optional<Cursor>& after, int limit);
  Outcome<Study> find(const Principal& who, const std::string& id);
  /// Returns kPrecondition if the study has another version, or kConflict if somebody has joined.
  Outcome<Study> replace(const Principal& who, const std::string& id, int version,
                         const StudyContent& content);
  Outcome<void> remove(const Principal& who, const std::string& id);
  /// Opens or closes the study. Returns kConflict if a picture is missing, a scan may not be used,
  /// or the study's end has passed.
  Outcome<Study> set_state(const Principal& who, const std::string& id, StudyState state);
  /// Returns the token of a new link.
  Outcome<std::string> make_link(const Principal& who, const std::string& id);
  /// `file` is a JPEG or PNG. Returns kInvalid for anything else, or with unknown `picture_id`.
  Outcome<void> put_picture(const Principal& who, const std::string& id,
                            const std::string& picture_id, const std::string& file);
  Outcome<StudyPicture> picture(const Principal& who, const std::string& id,
                                const std::string& picture_id);
  /// `format` is "json" or "csv".
  Outcome<File> make_export(const Principal& who, const std::string& id, const std::string& format);
  Outcome<File> analyse(const Principal& who, const std::string& id, const std::string& language);

  /// Replaces the published comfort by that of a study, for administrators. Returns kConflict if
  /// the study's analysis claims none.
  Outcome<void> adopt_comfort(const Principal& administrator, const std::string& id);
  Outcome<void> reset_comfort(const Principal& administrator);
  /// Returns JSON, or an empty string if nothing was adopted.
  Outcome<std::string> comfort();

  /// Uses the canonical views of a study's step for the tour of its scan. Returns kConflict if the
  /// analysis claims fewer than two views, or the scan was cut since the study opened.
  Outcome<void> adopt_tour(const Principal& who, const std::string& data_set_id,
                           const std::string& study_id, const std::string& step);
  Outcome<void> remove_tour(const Principal& who, const std::string& data_set_id);
  Outcome<Tour> tour(const Principal& who, const std::string& data_set_id);
  /// Returns the tour for a visitor with a link. The caller checks the link.
  Outcome<Tour> tour_of(const std::string& data_set_id);

  /// Closes studies that have ended, and removes old sessions, previews and files.
  void expire();

 private:
  void end(const StudyStore::SessionIds& sessions);
  Outcome<void> check_scans_and_pictures(const Principal& who, const Study& study);
  Outcome<std::string> run_analysis(const Study& study, const std::string& language);

  StudyStore& store_;
  DataSets& data_sets_;
  Placement& placement_;
  StudyAnalysis& analysis_;
  StudyExports& exports_;
  CheckPicture check_picture_;
  const Clock& clock_;
  std::mutex mutex_;
  int analyses_ = 0;  ///< that run now
};

}  // namespace diaphane::api
