#pragma once

#include <string>

#include "api/accounts/account_change_repository.h"
#include "api/accounts/account_changes.h"
#include "api/accounts/account_repository.h"
#include "api/accounts/accounts.h"
#include "api/accounts/api_token_repository.h"
#include "api/accounts/api_tokens.h"
#include "api/accounts/second_factor.h"
#include "api/accounts/second_factor_repository.h"
#include "api/administration/administration.h"
#include "api/administration/administration_repository.h"
#include "api/annotations/annotation_repository.h"
#include "api/annotations/annotations.h"
#include "api/environments/environment_repository.h"
#include "api/environments/environments.h"
#include "api/environments/panorama_child.h"
#include "api/pacs/archive_repository.h"
#include "api/pacs/archives.h"
#include "api/pacs/gateway_client.h"
#include "api/presets/preset_pictures.h"
#include "api/presets/preset_repository.h"
#include "api/presets/presets.h"
#include "api/presets/recording_repository.h"
#include "api/presets/recordings.h"
#include "api/privacy/account_deletion.h"
#include "api/privacy/exports.h"
#include "api/privacy/privacy_repository.h"
#include "api/scans/alignment_repository.h"
#include "api/scans/alignments.h"
#include "api/scans/anonymise.h"
#include "api/scans/anonymise_repository.h"
#include "api/scans/data_set_repository.h"
#include "api/scans/data_sets.h"
#include "api/scans/label_repository.h"
#include "api/scans/scan_export_repository.h"
#include "api/scans/scan_exports.h"
#include "api/scans/scan_labels.h"
#include "api/scans/thumbnails.h"
#include "api/scans/uploads.h"
#include "api/sessions/render_time.h"
#include "api/sessions/render_time_repository.h"
#include "api/sessions/sessions.h"
#include "api/settings.h"
#include "api/shared/signals.h"
#include "api/sharing/live_links.h"
#include "api/sharing/report_repository.h"
#include "api/sharing/reports.h"
#include "api/sharing/sharing.h"
#include "api/sharing/sharing_repository.h"
#include "api/stream/worker_error_curves.h"
#include "api/stream/worker_stills.h"
#include "api/studies/analysis_client.h"
#include "api/studies/participation.h"
#include "api/studies/studies.h"
#include "api/studies/study_repository.h"
#include "common/clock.h"
#include "directory/client.h"
#include "directory/links.h"
#include "directory/sessions.h"

/// The services of the REST API with their adapters. The members of each group are constructed in
/// order, because they refer to earlier ones, and destroyed in reverse. Nothing can be copied.
namespace diaphane::api {

/// The repositories that several groups use.
struct Stores {
  explicit Stores(const std::string& postgres);

  Database database;
  AccountRepository accounts{database};
  DataSetRepository data_sets{database};
  AccountChangeRepository account_changes{database};
  AdministrationRepository administration{database};
  RenderTimeRepository render_time{database};
  PrivacyRepository privacy{database};
  MailRepository mails{database};
};

/// The dependencies that all services share. They must outlive the services.
struct Backends {
  const Settings& settings;
  const Clock& clock;
  directory::Client& redis;
  directory::Sessions& placed;
  Stores& stores;
  Signals& signals;
};

struct AccountServices {
  explicit AccountServices(const Backends& on);
  AccountServices(const AccountServices&) = delete;

  PasswordHasher hasher;
  SecondFactorRepository factor_store;
  CodeCheck code_check;
  Accounts accounts;
  SecondFactors second_factors;
  AccountChanges changes;
  ApiTokenRepository token_store;
  ApiTokens tokens;
};

struct DataSetServices {
  explicit DataSetServices(const Backends& on);
  DataSetServices(const DataSetServices&) = delete;

  UploadFiles files;
  DataSets data_sets;
  Uploads uploads;
  ScanExportRepository export_store;
  ScanExports exports;
  AlignmentRepository alignment_store;
  Alignments alignments;
};

struct SessionServices {
  SessionServices(const Backends& on, DataSetServices& scans);
  SessionServices(const SessionServices&) = delete;
  std::string first_scene(const std::string& data_set);

  RenderTime render_time;
  PresetRepository preset_store;
  stream::WorkerErrorCurves error_curves;
  Sessions sessions;
  Administration administration;
};

struct PrivacyServices {
  PrivacyServices(const Backends& on, Accounts& accounts);
  PrivacyServices(const PrivacyServices&) = delete;

  Exports exports;
  AccountDeletion deletion;
};

/// Services for content that people can show to others.
struct SharedServices {
  SharedServices(const Backends& on, DataSets& data_sets, SessionServices& sessions);
  SharedServices(const SharedServices&) = delete;

  directory::Links link_store;
  RecordingRepository recording_store;
  Recordings recordings;
  SharingRepository sharing_store;
  const SharingParts parts;
  Sharing sharing;
  Visits visits;
  Presets presets;
  AnnotationRepository annotation_store;
  AnnotationSets annotations;
  EnvironmentRepository environment_store;
  SandboxedImporter importer;
  Environments environments;
  ReportRepository report_store;
  Reports reports;
  LiveLinks live_links;
};

struct PictureServices {
  PictureServices(const Backends& on, DataSets& data_sets, Presets& presets,
                  PresetRepository& preset_store);
  PictureServices(const PictureServices&) = delete;

  stream::WorkerStills stills;
  Thumbnails thumbnails;
  PresetPictures preset_pictures;
  CutRepository cut_store;
  Anonymise anonymise;
  LabelRepository label_store;
  ScanLabels labels;
};

/// Studies of perception and their participants.
struct StudyServices {
  StudyServices(const Backends& on, DataSets& data_sets, RenderTime& render_time);
  StudyServices(const StudyServices&) = delete;

  StudyRepository store;
  ParticipantRepository participant_store;
  AnalysisClient analysis;
  StudyExports exports;
  Studies studies;
  Participations participations;
};

/// The hospital's archives.
struct ArchiveServices {
  explicit ArchiveServices(const Backends& on);
  ArchiveServices(const ArchiveServices&) = delete;

  ArchiveRepository store;
  GatewayClient gateway;
  Archives archives;
};

struct Services {
  explicit Services(const Backends& on);

  AccountServices account;
  DataSetServices data_set;
  SessionServices session;
  PrivacyServices privacy;
  SharedServices shared;
  PictureServices picture;
  StudyServices study;
  ArchiveServices archive;
};

/// The directory of finished exports, which the reverse proxy sends.
std::string export_directory(const Settings& settings);

}  // namespace diaphane::api
