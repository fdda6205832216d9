#include "api/service/sharing.h"

#include <utility>

#include "api/service/password.h"
#include "api/service/secrets.h"
#include "common/ids.h"
#include "common/log.h"

namespace diaphane::api {
namespace {

Mail invitation(const std::string& email, const std::string& from, const std::string& public_url) {
  return {email, "Somebody shares a scan with you on Diaphane",
          (from.empty() ? std::string("Somebody") : from) +
              " shares a scan with you on Diaphane.\n\nSign in with this address, or create an "
              "account with it, and you find the scan under \"My scans\":\n\n" +
              public_url +
              "/scans\n\nIf you do not know what this is about, do nothing: nobody is told whether "
              "you have an account.\n"};
}

tl::unexpected<Problem> no_such_link() {
  return refuse(ProblemKind::kNotFound, "This link was ended, or never was one.");
}

}  // namespace

Sharing::Sharing(DataSets& data_sets, SharingStore& store, AccountStore& accounts,
                 Placement& placement, const Clock& clock, Options options)
    : data_sets_(data_sets),
      store_(store),
      accounts_(accounts),
      placement_(placement),
      clock_(clock),
      options_(std::move(options)) {}

Outcome<std::vector<SharedPerson>> Sharing::people(const Principal& who, const std::string& id) {
  if (auto mine = data_sets_.authorise(who, id, Action::kShare); !mine) {
    return tl::unexpected(mine.error());
  }
  auto found = store_.people(id);
  if (!found) return refuse(found.error());
  return *std::move(found);
}

Outcome<void> Sharing::share_with(const Principal& who, const std::string& id,
                                  const std::string& email, bool may_save) {
  if (!is_email(email)) return refuse_field("email", "This is not an e-mail address.");
  if (auto mine = data_sets_.authorise(who, id, Action::kShare); !mine) {
    return tl::unexpected(mine.error());
  }
  const std::string key = email_key(email);
  if (key == email_key(who.email)) return refuse_field("email", "This is your own address.");
  const auto now = clock_.wall();
  // Each of them may send a mail to a stranger.
  const auto wait = accounts_.note_attempt(
      {{blake2b("invite:" + who.user_id), options_.invitations, std::chrono::hours(24)}}, now);
  if (!wait) return refuse(wait.error());
  if (*wait) {
    return refuse(ProblemKind::kTooManyAttempts,
                  "You have shared with many people today. Go on tomorrow.", **wait);
  }
  const auto name = store_.public_name(who.user_id);
  if (!name) return refuse(name.error());
  const auto added = store_.share_with(id, {new_id(), key, may_save, now}, options_.people,
                                       invitation(email, *name, options_.public_url));
  if (!added) return refuse(added.error());
  if (*added) wake_mailer_();
  return {};
}

Outcome<void> Sharing::unshare(const Principal& who, const std::string& id,
                               const std::string& person_id) {
  if (auto mine = data_sets_.authorise(who, id, Action::kShare); !mine) {
    return tl::unexpected(mine.error());
  }
  const auto nobody = [] {
    return refuse(ProblemKind::kNotFound, "It is not shared with this person.");
  };
  if (!is_id(person_id)) return nobody();
  const auto done = store_.unshare(id, person_id);
  if (!done && done.error().code == ErrorCode::kNotFound) return nobody();
  if (!done) return refuse(done.error());
  end_lost_sessions(id);
  return {};
}

Outcome<std::vector<DataSetLink>> Sharing::links(const Principal& who, const std::string& id) {
  if (auto mine = data_sets_.authorise(who, id, Action::kShare); !mine) {
    return tl::unexpected(mine.error());
  }
  auto found = store_.links(id, clock_.wall());
  if (!found) return refuse(found.error());
  return *std::move(found);
}

Outcome<Sharing::NewLink> Sharing::make_link(const Principal& who, const std::string& id,
                                             std::chrono::hours life) {
  if (auto mine = data_sets_.authorise(who, id, Action::kShare); !mine) {
    return tl::unexpected(mine.error());
  }
  const auto now = clock_.wall();
  NewLink made{{new_id(), now, now + life}, random_hex(32)};
  const auto done = store_.make_link(id, made.link, blake2b(made.token), options_.links);
  if (!done) return refuse(done.error());
  return made;
}

Outcome<void> Sharing::end_link(const Principal& who, const std::string& id,
                                const std::string& link_id) {
  if (auto mine = data_sets_.authorise(who, id, Action::kShare); !mine) {
    return tl::unexpected(mine.error());
  }
  if (!is_id(link_id)) return no_such_link();
  const auto done = store_.end_link(id, link_id);
  if (!done && done.error().code == ErrorCode::kNotFound) return no_such_link();
  if (!done) return refuse(done.error());
  end_lost_sessions(id);
  return {};
}

Outcome<DataSet> Sharing::publish(const Principal& who, const std::string& id) {
  const auto mine = data_sets_.authorise(who, id, Action::kPublish);
  if (!mine) return mine;
  if (mine->state != DataSetState::kReady) {
    return refuse(ProblemKind::kNotReady, "Only what is built can be made public.");
  }
  const auto done = store_.publish(id, clock_.wall());
  if (!done) return refuse(done.error());
  if (!*done) {
    return refuse(ProblemKind::kNotAnonymised,
                  "Before a scan becomes public, cut away what could show who it is, and confirm "
                  "it.");
  }
  return data_sets_.find(who, id);
}

Outcome<DataSet> Sharing::make_private(const Principal& who, const std::string& id) {
  if (auto mine = data_sets_.authorise(who, id, Action::kPublish); !mine) return mine;
  const auto done = store_.make_private(id, clock_.wall());
  if (!done) return refuse(done.error());
  end_lost_sessions(id);
  return data_sets_.find(who, id);
}

Outcome<Sharing::Page> Sharing::gallery(const Principal& who, GalleryQuestion question) {
  const int limit = question.limit++;
  question.samples_only = !may(Role::kOther, Action::kFind, Exposure::kPublic) ||
                          (who.user_id.empty() && !who.sample_operator);
  auto found = store_.gallery({who.user_id, who.sample_operator, who.administrator}, question);
  if (!found) return refuse(found.error());
  Page page{*std::move(found), std::nullopt};
  if (static_cast<int>(page.items.size()) > limit) {
    page.items.pop_back();
    const DataSet& last = page.items.back();
    page.next = Cursor{std::chrono::duration_cast<std::chrono::microseconds>(
                           last.published_at.value_or(last.created_at).time_since_epoch())
                           .count(),
                       last.id};
  }
  return page;
}

Outcome<std::string> Sharing::public_name(const Principal& who) {
  auto name = store_.public_name(who.user_id);
  if (!name) return refuse(name.error());
  return *std::move(name);
}

Outcome<void> Sharing::set_public_name(const Principal& who, const std::string& name) {
  if (name.find('@') != std::string::npos) {
    return refuse_field("public_name", "Choose a name, not an address: everybody sees it.");
  }
  const auto done = store_.set_public_name(who.user_id, name);
  if (!done) return refuse(done.error());
  return {};
}

void Sharing::end_lost_sessions(const std::string& id) {
  const auto failed = [&] { log::warning("sessions not ended", {{"data_set", id}}); };
  const auto sessions = placement_.sessions_on(id);
  if (!sessions) return failed();
  for (const SessionInfo& session : *sessions) {
    Principal person;
    person.user_id = session.user_id;
    const auto still = data_sets_.find_ready(person, id);
    if (still) continue;
    if (still.error().kind == ProblemKind::kUnavailable) return failed();
    if (store_.find_visit(session.id, clock_.wall())) continue;
    if (!placement_.end(session.id)) failed();
  }
}

Visits::Visits(DataSets& data_sets, SharingStore& store, AccountStore& accounts,
               Placement& placement, const Clock& clock, Options options)
    : data_sets_(data_sets),
      store_(store),
      accounts_(accounts),
      placement_(placement),
      clock_(clock),
      options_(options) {}

Outcome<SharingStore::Followed> Visits::follow(const std::string& token) {
  if (!is_token(token)) return no_such_link();
  auto found = store_.follow(blake2b(token), clock_.wall());
  if (!found && found.error().code == ErrorCode::kNotFound) return no_such_link();
  if (!found) return refuse(found.error());
  return *std::move(found);
}

Outcome<Visits::Opened> Visits::open(const std::string& token, const std::string& data_set_id,
                                     const std::string& key, const std::string& address) {
  const auto now = clock_.wall();
  const std::string visitor = id_from("visitor\n" + key);
  Visit visit;
  if (token.empty()) {
    const auto sample = data_sets_.find_ready(Principal{}, data_set_id);
    if (!sample) return tl::unexpected(sample.error());
    visit.data_set_id = sample->id;
    visit.expires_at = now + options_.sample_life;
  } else {
    const auto followed = follow(token);
    if (!followed) return tl::unexpected(followed.error());
    visit.data_set_id = followed->data_set.id;
    visit.link_id = followed->link.id;
    visit.expires_at = std::min(followed->link.expires_at, Time(now + options_.link_life));
  }
  // With the link: another link with the same key is another visit.
  visit.session_id = id_from("visit\n" + key + "\n" + visit.data_set_id + "\n" + visit.link_id);
  if (const auto known = store_.find_visit(visit.session_id, now); !known) {
    if (known.error().code != ErrorCode::kNotFound) return refuse(known.error());
    const auto wait = accounts_.note_attempt(
        {{blake2b("visit:" + address), options_.by_address, std::chrono::minutes(15)}}, now);
    if (!wait) return refuse(wait.error());
    if (*wait) {
      return refuse(ProblemKind::kTooManyAttempts,
                    "Many people look from where you are. Try again in a while, or sign up.",
                    **wait);
    }
  }
  const auto noted = store_.note_visit(visit, options_.most, now);
  if (!noted && noted.error().code == ErrorCode::kTooMany) {
    return refuse(ProblemKind::kBusy,
                  "All places for visitors are taken. Try again in a few minutes, or sign up.",
                  std::chrono::seconds(30));
  }
  if (!noted) return refuse(noted.error());
  const auto placed = placement_.place({visit.session_id, visitor, visit.data_set_id});
  if (!placed && placed.error().code == ErrorCode::kUnavailable && placement_.reachable()) {
    return refuse(ProblemKind::kNoWorker, placed.error().message, std::chrono::seconds(2));
  }
  if (!placed) return refuse(placed.error());
  // Taken away while it was placed: whoever took it may not have seen this session.
  if (!store_.find_visit(visit.session_id, now)) {
    (void)placement_.end(visit.session_id);
    return no_such_link();
  }
  return Opened{visit.session_id, "/stream?ticket=" + placed->ticket, noted->expires_at};
}

void Visits::expire() {
  const auto now = clock_.wall();
  const auto over = store_.expired_visits(now);
  if (!over) return;
  for (const std::string& session : *over) {
    // Forgotten once it has ended: with Redis away it is tried again.
    if (placement_.end(session)) (void)store_.forget_visit(session);
  }
  (void)store_.expire_links(now);
}

}  // namespace diaphane::api
