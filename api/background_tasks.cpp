#include "api/background_tasks.h"

#include <algorithm>

#include "volume/store.h"

namespace diaphane::api {

using namespace std::chrono_literals;

BackgroundTasks::BackgroundTasks(const Backends& on, Services& services, MailTransport& transport,
                                 RequestMetrics& metrics)
    : settings_(on.settings),
      clock_(on.clock),
      stores_(on.stores),
      services_(services),
      metrics_(metrics),
      mailer_(stores_.mails, transport, clock_),
      disposer_(stores_.data_sets, services.data_set.files, services.picture.thumbnails,
                services.picture.preset_pictures, services.shared.environments,
                settings_.volume_dir, export_directory(settings_)),
      send_mails_("mail", at_most(2s),
                  [this] {
                    const auto [sent, failed] = mailer_.send_due();
                    metrics_.mails(sent, failed);
                  }),
      make_pictures_("preset thumbnails", at_most(5s),
                     [this] {
                       while (services_.picture.preset_pictures.make_next()) {
                       }
                     }),
      dispose_("disposal", at_most(5s), [this] { delete_disposed(); }),
      end_visits_("visits", at_most(5s), [this] { services_.shared.visits.expire(); }),
      end_studies_("studies", at_most(5s), [this] { services_.study.studies.expire(); }),
      end_browsers_("expired web sessions", at_most(5s),
                    [this] { services_.account.changes.end_expired_browsers(); }),
      tidy_("tidying", 10min,
            [this] {
              (void)stores_.accounts.tidy(clock_.wall());
              (void)stores_.data_sets.expire_views(clock_.wall());
              (void)services_.shared.recording_store.expire(clock_.wall());
            }),
      count_render_time_("rendering time", at_most(2s),
                         [this] { services_.session.render_time.poll(); }),
      make_exports_("exports", at_most(2s), [this] {
        services_.data_set.exports.expire();
        services_.privacy.exports.poll();
      }) {
  on.signals.subscribe(Signal::kMail, [this] { send_mails_.wake(); });
  on.signals.subscribe(Signal::kDisposal, [this] { dispose_.wake(); });
  on.signals.subscribe(Signal::kPicture, [this] { make_pictures_.wake(); });
  on.signals.subscribe(Signal::kExport, [this] { make_exports_.wake(); });
  // Ends the streams within the request, so that the pictures have stopped when it is answered.
  on.signals.subscribe(Signal::kSignOut,
                       [this] { services_.account.changes.end_expired_browsers(); });
}

void BackgroundTasks::delete_disposed() {
  (void)stores_.data_sets.expire_uploads(clock_.wall());
  const int gone = disposer_.dispose();
  metrics_.disposed(gone);
  // A thumbnail may have waited for the deletion of its predecessor.
  if (gone > 0) make_pictures_.wake();
  // Removes partial volumes that a killed ingestd left behind, even while no ingestd runs.
  (void)volume::sweep_unfinished(settings_.volume_dir);
}

std::chrono::milliseconds BackgroundTasks::at_most(std::chrono::milliseconds period) const {
  return std::min(period, settings_.background);
}

}  // namespace diaphane::api
