#include "api/services.h"

#include "api/archive/zip_writer.h"
#include "api/presets/preset_format.h"
#include "api/studies/picture_check.h"
#include "volume/store.h"
#include "volume/volume.h"

namespace diaphane::api {
namespace {

constexpr int kConnections = 12;
constexpr int kHashingSlots = 2;
/// Maximum size of a label upload: LabelLimits::file_bytes of ingest plus archive headers.
constexpr std::int64_t kMostLabelBytes = (std::int64_t{1} << 30) + (1 << 16);

}  // namespace

Stores::Stores(const std::string& postgres) : database(postgres, kConnections) {}

AccountServices::AccountServices(const Backends& on)
    : hasher(kHashingSlots),
      factor_store(on.stores.database),
      code_check(factor_store, on.stores.accounts, on.settings.factor_key.value(), on.clock,
                 on.signals, {.public_url = on.settings.public_url}),
      accounts(
          on.stores.accounts, hasher, code_check, on.settings.factor_key.value(), on.clock,
          on.signals,
          {.public_url = on.settings.public_url, .consent_version = on.settings.consent_version}),
      second_factors(factor_store, accounts, code_check, on.settings.factor_key.value(), on.clock,
                     on.signals, {}),
      changes(on.stores.account_changes, on.stores.accounts, accounts, hasher, on.placed, on.clock,
              on.signals, {.public_url = on.settings.public_url}),
      token_store(on.stores.database),
      tokens(token_store, accounts, on.clock, on.signals, {on.settings.public_url + "/account"}) {}

DataSetServices::DataSetServices(const Backends& on)
    : files(on.settings.upload_dir),
      data_sets(on.stores.data_sets, on.placed, on.clock, on.signals, on.settings.data_sets,
                [this] { return files.free_bytes(); }),
      // Uploads that were announced before the disk filled up may use half of the reserve.
      uploads(on.stores.data_sets, files, on.clock, on.signals, on.settings.data_sets.upload_life,
              on.settings.data_sets.reserve_bytes / 2),
      export_store(on.stores.database),
      exports(data_sets, export_store, on.clock, on.signals, on.settings.export_total_bytes),
      alignment_store(on.stores.database),
      alignments(data_sets, alignment_store, on.clock,
                 [&settings = on.settings](const std::string& id) {
                   return volume::read_header(settings.volume_dir + "/" + id);
                 }) {}

SessionServices::SessionServices(const Backends& on, DataSetServices& scans)
    : render_time(on.stores.render_time, on.placed, on.placed, on.clock),
      preset_store(on.stores.database),
      error_curves(on.placed, on.settings.tls),
      sessions(
          scans.data_sets, on.placed, render_time, error_curves,
          [this](const std::string& data_set) { return first_scene(data_set); },
          [&alignments = scans.alignments](const Principal& who, const std::string& first,
                                           const std::string& second) {
            return alignments.motion(who, first, second);
          }),
      administration(on.stores.administration, on.placed, on.placed, on.clock) {}

/// Returns the scene of the owner's default preset in serialised form. If there is none or it is
/// unavailable, returns an empty string, which means the volume's default appearance.
std::string SessionServices::first_scene(const std::string& data_set) {
  const auto scene = preset_store.default_scene(data_set);
  return scene && !scene->empty() ? scene_bytes(*scene) : std::string();
}

PrivacyServices::PrivacyServices(const Backends& on, Accounts& accounts)
    : exports(on.stores.privacy, ZipWriter::create, on.clock, on.signals,
              {.volumes = on.settings.volume_dir,
               .pictures = on.settings.cache_dir + "/presets",
               .exports = export_directory(on.settings),
               .reserve_bytes = on.settings.data_sets.reserve_bytes,
               .total_bytes = on.settings.export_total_bytes}),
      deletion(on.stores.privacy, accounts, on.placed, on.clock, on.signals) {}

SharedServices::SharedServices(const Backends& on, DataSets& data_sets, SessionServices& sessions)
    : link_store(on.redis),
      recording_store(on.stores.database),
      recordings(recording_store, on.clock),
      sharing_store(on.stores.database),
      parts{data_sets, sharing_store, on.stores.accounts, on.placed, on.clock, on.signals},
      sharing(parts, {.public_url = on.settings.public_url}),
      visits(parts, {},
             [&sessions](const std::string& data_set) { return sessions.first_scene(data_set); }),
      presets(data_sets, sessions.preset_store, on.clock, on.signals),
      annotation_store(on.stores.database),
      annotations(data_sets, annotation_store, on.clock),
      environment_store(on.stores.database),
      importer("/proc/self/exe"),
      environments(environment_store, importer, on.clock, on.signals, on.settings.volume_dir),
      report_store(on.stores.database),
      reports(data_sets, presets, report_store, on.stores.accounts, on.clock,
              [this](const std::string& data_set) { sharing.end_lost_sessions(data_set); }),
      live_links(data_sets, on.placed, link_store, on.stores.accounts, on.clock, {}) {}

PictureServices::PictureServices(const Backends& on, DataSets& data_sets, Presets& presets,
                                 PresetRepository& preset_store)
    : stills(on.placed, on.settings.tls),
      thumbnails(data_sets, stills, on.settings.cache_dir),
      preset_pictures(data_sets, presets, preset_store, stills, on.clock, on.settings.cache_dir,
                      scene_bytes),
      cut_store(on.stores.database),
      anonymise(data_sets, cut_store, thumbnails, on.placed, on.clock, on.signals,
                [&settings = on.settings](const std::string& id) {
                  const auto header = volume::read_header(settings.volume_dir + "/" + id);
                  return header ? header->content_hash : std::string();
                }),
      label_store(on.stores.database),
      labels(data_sets, label_store, on.clock, on.signals, kMostLabelBytes,
             [&settings = on.settings](const std::string& id) {
               return volume::remove_label_set(settings.volume_dir + "/" + id);
             }) {}

StudyServices::StudyServices(const Backends& on, DataSets& data_sets, RenderTime& render_time)
    : store(on.stores.database),
      participant_store(on.stores.database),
      analysis(on.settings.study_analysis_url),
      exports(store, ZipWriter::create, on.settings.cache_dir),
      studies(store, data_sets, on.placed, analysis, exports, check_picture, on.clock),
      participations({store, participant_store, data_sets, on.stores.accounts, render_time,
                      on.placed, on.clock, on.settings.factor_key.value()},
                     {}, scene_bytes) {}

ArchiveServices::ArchiveServices(const Backends& on)
    : store(on.stores.database),
      gateway(on.settings.archive_url, on.settings.archive_key),
      archives(gateway, store, on.settings.factor_key.value(), on.clock) {}

Services::Services(const Backends& on)
    : account(on),
      data_set(on),
      session(on, data_set),
      privacy(on, account.accounts),
      shared(on, data_set.data_sets, session),
      picture(on, data_set.data_sets, shared.presets, session.preset_store),
      study(on, data_set.data_sets, session.render_time),
      archive(on) {}

std::string export_directory(const Settings& settings) { return settings.cache_dir + "/exports"; }

}  // namespace diaphane::api
