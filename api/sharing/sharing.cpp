#include "api/sharing/sharing.h"

#include <utility>

#include "api/accounts/account_mails.h"
#include "api/accounts/password.h"
#include "api/shared/secrets.h"
#include "common/ids.h"
#include "common/log.h"
#include "common/names.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

tl::unexpected<Problem> no_such_link() {
  return refuse(ProblemKind::kNotFound, "This link is invalid or has been disabled.");
}

tl::unexpected<Problem> no_such_person() {
  return refuse(ProblemKind::kNotFound, "This scan is not shared with this person.");
}

tl::unexpected<Problem> no_place_for_visitors() {
  return refuse(ProblemKind::kBusy,
                "All guest places are taken. Try again in a few minutes, or sign up.",
                std::chrono::seconds(30));
}

tl::unexpected<Problem> too_many_from_network(std::chrono::seconds wait) {
  return refuse(ProblemKind::kTooManyAttempts,
                "Too many people are viewing scans from your network. Try again later, or sign up.",
                wait);
}

/// Counts an attempt for the address, but only one for each key within the window: a page that
/// tries again every two seconds because no slot is free must not be locked out. Returns the time
/// to wait.
Result<std::optional<std::chrono::seconds>> note_first_attempt(AccountStore& accounts,
                                                               const Visit& visit, int by_address,
                                                               Time now) {
  constexpr std::chrono::minutes kWindow{15};
  const std::string key = blake2b("visit key:" + visit.session_id);
  const auto known = accounts.note_attempt({{key, 1, kWindow}}, now);
  DIAPHANE_TRY(known);
  if (*known) return std::nullopt;
  auto wait = accounts.note_attempt({{visit.address_hash, by_address, kWindow}}, now);
  if (!wait || *wait) (void)accounts.forget_attempts(key, now);
  return wait;
}

/// Records a new visit with a link in the logs. Ends the visit if its access was revoked during the
/// placement by a request that did not see its session.
Outcome<void> confirm_visit(const SharingParts& parts, const Visit& visit, const Client& client,
                            Time now) {
  const auto still = parts.store.find_visit(visit.session_id, now);
  if (still && visit.link_id.empty()) return {};  // visits to samples are not logged
  if (still) {
    return parts.data_sets.note_view(visit.data_set_id,
                                     {ViewRoute::kLink, visit.session_id, visit.link_id, client});
  }
  (void)parts.placement.end(visit.session_id);
  if (still.error().code == ErrorCode::kNotFound) return no_such_link();
  return refuse(still.error());
}

}  // namespace

Outcome<std::vector<SharedPerson>> Sharing::people(const Principal& who, const std::string& id) {
  DIAPHANE_TRY(parts_.data_sets.authorise(who, id, Action::kShare));
  auto found = parts_.store.people(id);
  if (!found) return refuse(found.error());
  return *std::move(found);
}

Outcome<void> Sharing::share_with(const Principal& who, const std::string& id,
                                  const std::string& email, bool may_save,
                                  const Permissions& allowed) {
  if (!is_email(email)) return refuse_field("email", "Enter a valid email address.");
  DIAPHANE_TRY(parts_.data_sets.authorise(who, id, Action::kShare));
  const std::string key = email_key(email);
  if (key == email_key(who.email)) return refuse_field("email", "This is your own email address.");
  const auto now = parts_.clock.wall();
  // The number is limited, because each invitation may send an email to a stranger.
  const auto wait = parts_.accounts.note_attempt(
      {{blake2b("invite:" + who.user_id), options_.invitations, std::chrono::hours(24)}}, now);
  if (!wait) return refuse(wait.error());
  if (*wait) {
    return refuse(ProblemKind::kTooManyAttempts,
                  "You have reached today's sharing limit. Try again tomorrow.", **wait);
  }
  const auto name = parts_.store.public_name(who.user_id);
  if (!name) return refuse(name.error());
  const auto added = parts_.store.share_with(
      id, {new_id(), key, may_save, allowed, now}, options_.people,
      mails::invitation(email, *name, who.email, options_.public_url + "/scans"));
  if (!added) return refuse(added.error());
  if (added->added) parts_.signals.raise(Signal::kMail);
  if (!added->narrowed_user_id.empty()) end_sessions_of(id, added->narrowed_user_id);
  return {};
}

Outcome<void> Sharing::change_person(const Principal& who, const std::string& id,
                                     const std::string& person_id, const PersonChange& change) {
  DIAPHANE_TRY(parts_.data_sets.authorise(who, id, Action::kShare));
  if (!is_id(person_id)) return no_such_person();
  const auto changed = parts_.store.change_person(id, person_id, change, parts_.clock.wall());
  if (!changed && changed.error().code == ErrorCode::kNotFound) return no_such_person();
  if (!changed) return refuse(changed.error());
  if (!changed->narrowed_user_id.empty()) end_sessions_of(id, changed->narrowed_user_id);
  return {};
}

Outcome<void> Sharing::unshare(const Principal& who, const std::string& id,
                               const std::string& person_id) {
  DIAPHANE_TRY(parts_.data_sets.authorise(who, id, Action::kShare));
  if (!is_id(person_id)) return no_such_person();
  const auto done = parts_.store.unshare(id, person_id, parts_.clock.wall());
  if (!done && done.error().code == ErrorCode::kNotFound) return no_such_person();
  if (!done) return refuse(done.error());
  // Of a public scan, their sessions would otherwise keep what only this permission allowed.
  if (!done->empty()) end_sessions_of(id, *done);
  end_lost_sessions(id);
  return {};
}

Outcome<std::vector<DataSetLink>> Sharing::links(const Principal& who, const std::string& id) {
  DIAPHANE_TRY(parts_.data_sets.authorise(who, id, Action::kShare));
  auto found = parts_.store.links(id, parts_.clock.wall());
  if (!found) return refuse(found.error());
  return *std::move(found);
}

Outcome<Sharing::NewLink> Sharing::make_link(const Principal& who, const std::string& id,
                                             std::chrono::hours life, const Permissions& allowed,
                                             const IdempotencyScope& once) {
  DIAPHANE_TRY(parts_.data_sets.authorise(who, id, Action::kShare));
  const auto now = parts_.clock.wall();
  const NewLink created{{new_id(), now, now + life, allowed}, token_for("link\n" + id, once)};
  std::optional<IdempotencyKey> key;
  if (!once.key.empty()) {
    key = IdempotencyKey{
        "createDataSetLink", once.key,
        blake2b(id + "\n" + std::to_string(life.count()) + (allowed.slices ? "\nslices" : "") +
                (allowed.downloads ? "\ndownloads" : ""))};
  }
  const auto made = parts_.store.make_link(id, created.link, blake2b(created.token), options_.links,
                                           who.user_id, key);
  if (!made && made.error().code == ErrorCode::kConflict) {
    return refuse(ProblemKind::kConflict,
                  "The link created with this Idempotency-Key has been disabled or belongs to "
                  "another browser. Create a new link.");
  }
  if (!made) return refuse(made.error());
  if (std::holds_alternative<KeyReused>(*made)) {
    return refuse(ProblemKind::kIdempotencyKeyReused,
                  "This Idempotency-Key was already used with a different request.");
  }
  return NewLink{std::get<DataSetLink>(*made), created.token};
}

Outcome<void> Sharing::end_link(const Principal& who, const std::string& id,
                                const std::string& link_id) {
  DIAPHANE_TRY(parts_.data_sets.authorise(who, id, Action::kShare));
  if (!is_id(link_id)) return no_such_link();
  const auto done = parts_.store.end_link(id, link_id, parts_.clock.wall());
  if (!done && done.error().code == ErrorCode::kNotFound) return no_such_link();
  if (!done) return refuse(done.error());
  end_lost_sessions(id);
  return {};
}

Outcome<DataSet> Sharing::publish(const Principal& who, const std::string& id,
                                  const Permissions& allowed) {
  const auto mine = parts_.data_sets.authorise(who, id, Action::kPublish);
  if (!mine) return mine;
  if (mine->state != DataSetState::kReady) {
    return refuse(ProblemKind::kNotReady, "A scan can be made public only once it is ready.");
  }
  const auto done = parts_.store.publish(id, allowed, parts_.clock.wall());
  if (!done) return refuse(done.error());
  if (!*done) {
    return refuse(ProblemKind::kNotAnonymised,
                  "Before you make a scan public, remove anything that could identify the person "
                  "and confirm it.");
  }
  const Permissions before = mine->allowed_to_public();
  const Permissions withdrawn{before.slices && !allowed.slices,
                              before.downloads && !allowed.downloads};
  if (withdrawn.slices || withdrawn.downloads) end_public_sessions(id, withdrawn);
  return parts_.data_sets.find(who, id);
}

Outcome<DataSet> Sharing::make_private(const Principal& who, const std::string& id) {
  const auto mine = parts_.data_sets.authorise(who, id, Action::kPublish);
  if (!mine) return mine;
  const auto done = parts_.store.make_private(id, parts_.clock.wall());
  if (!done) return refuse(done.error());
  end_public_sessions(id, mine->allowed_to_public());
  return parts_.data_sets.find(who, id);
}

Outcome<Sharing::Page> Sharing::gallery(const Principal& who, GalleryQuery query) {
  const int limit = query.limit++;
  query.samples_only = !may(Role::kOther, Action::kFind, Exposure::kPublic) ||
                       (who.user_id.empty() && !who.sample_operator);
  auto found = parts_.store.gallery({who.user_id, who.sample_operator, who.administrator}, query);
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
  auto name = parts_.store.public_name(who.user_id);
  if (!name) return refuse(name.error());
  return *std::move(name);
}

Outcome<void> Sharing::set_public_name(const Principal& who, const std::string& name) {
  if (!is_plain_name(name)) {
    return refuse_field("public_name",
                        "Use only letters, digits, spaces, hyphens, apostrophes and a full stop "
                        "after an abbreviation. Others will see this name.");
  }
  const auto done = parts_.store.set_public_name(who.user_id, name);
  if (!done) return refuse(done.error());
  return {};
}

void Sharing::end_lost_sessions(const std::string& id) {
  end_sessions_unless(id, [](const DataSet&) { return true; });
}

void Sharing::end_sessions_of(const std::string& id, const std::string& user_id) {
  const auto failed = [&] { log::warning("failed to end sessions", {{"data_set", id}}); };
  const auto sessions = parts_.placement.sessions_on(id);
  if (!sessions) return failed();
  for (const SessionInfo& session : *sessions) {
    if (session.user_id == user_id && !parts_.placement.end(session.id)) failed();
  }
}

void Sharing::end_public_sessions(const std::string& id, const Permissions& withdrawn) {
  end_sessions_unless(id, [&](const DataSet& visible) {
    if (visible.owned()) return true;
    const Permissions own = visible.role == Role::kOther ? Permissions() : visible.to_person;
    return (own.slices || !withdrawn.slices) && (own.downloads || !withdrawn.downloads);
  });
}

void Sharing::end_sessions_unless(const std::string& id,
                                  const std::function<bool(const DataSet& visible)>& keeps) {
  const auto failed = [&] { log::warning("failed to end sessions", {{"data_set", id}}); };
  const auto sessions = parts_.placement.sessions_on(id);
  if (!sessions) return failed();
  for (const SessionInfo& session : *sessions) {
    Principal person;
    const bool of_study = !session.charged_to.empty();
    person.user_id = of_study ? session.charged_to : session.user_id;
    const auto visible = parts_.data_sets.find_ready(person, id);
    // A study may show less than its researcher may see (find_for_study).
    if (visible && (of_study ? visible->owned() || visible->is_public : keeps(*visible))) continue;
    if (!visible && (visible.error().kind == ProblemKind::kUnavailable ||
                     visible.error().kind == ProblemKind::kOutcomeUnknown)) {
      return failed();
    }
    const auto visit = parts_.store.find_visit(session.id, parts_.clock.wall());
    if (visit) continue;
    if (visit.error().code != ErrorCode::kNotFound) return failed();
    if (!parts_.placement.end(session.id)) failed();
  }
}

Outcome<SharingStore::Followed> Visits::follow(const std::string& token) {
  if (!is_token(token)) return no_such_link();
  auto found = parts_.store.follow(blake2b(token), parts_.clock.wall());
  if (!found && found.error().code == ErrorCode::kNotFound) return no_such_link();
  if (!found) return refuse(found.error());
  return *std::move(found);
}

Outcome<Visits::Opened> Visits::open(const std::string& token, const std::string& data_set_id,
                                     const std::string& key, const Client& client) {
  const auto now = parts_.clock.wall();
  const std::string visitor = id_from("visitor\n" + key);
  Visit visit;
  Permissions allowed{true, true};  // as for every viewer of a sample; a link has its own
  visit.address_hash = blake2b("visit:" + client.address);
  if (token.empty()) {
    const auto sample = parts_.data_sets.find_ready(Principal{}, data_set_id);
    DIAPHANE_TRY(sample);
    visit.data_set_id = sample->id;
    visit.expires_at = now + options_.sample_life;
  } else {
    const auto followed = follow(token);
    DIAPHANE_TRY(followed);
    visit.data_set_id = followed->data_set.id;
    visit.link_id = followed->link.id;
    allowed = followed->link.allowed;
    visit.expires_at = std::min(followed->link.expires_at, Time(now + options_.link_life));
  }
  // The ID includes the link, so that the same key with another link is another visit.
  visit.session_id = id_from("visit\n" + key + "\n" + visit.data_set_id + "\n" + visit.link_id);
  if (const auto known = parts_.store.find_visit(visit.session_id, now); !known) {
    if (known.error().code != ErrorCode::kNotFound) return refuse(known.error());
    const auto wait = note_first_attempt(parts_.accounts, visit, options_.by_address, now);
    if (!wait) return refuse(wait.error());
    if (*wait) {
      return too_many_from_network(**wait);
    }
  }
  const auto noted = parts_.store.note_visit(visit, options_.at_once, now);
  if (!noted && noted.error().code == ErrorCode::kTooMany) {
    if (noted.error().field == "address") return too_many_from_network(std::chrono::minutes(5));
    return no_place_for_visitors();
  }
  if (!noted) return refuse(noted.error());
  PlaceRequest request{visit.session_id, visitor, visit.data_set_id};
  request.first_scene = first_scene_(visit.data_set_id);
  request.viewer = token.empty() ? SessionViewer::kSampleVisitor : SessionViewer::kLinkVisitor;
  request.slices = allowed.slices;
  request.downloads = allowed.downloads;
  request.visitor = true;
  request.visitor_from = visit.address_hash;
  const auto placed = parts_.placement.place(request);
  const bool no_slot =
      !placed && (placed.error().code == ErrorCode::kTooLarge ||
                  (placed.error().code == ErrorCode::kUnavailable && parts_.placement.reachable()));
  // No session was opened, so the record must not count as a visit.
  if (no_slot) (void)parts_.store.forget_visit(visit.session_id);
  if (no_slot && placed.error().code == ErrorCode::kTooLarge) return no_place_for_visitors();
  if (no_slot) {
    return refuse(ProblemKind::kNoWorker, placed.error().message, std::chrono::seconds(2));
  }
  if (!placed) return refuse(placed.error());
  DIAPHANE_TRY(confirm_visit(parts_, visit, client, now));
  return Opened{visit.session_id, "/stream?ticket=" + placed->ticket, noted->expires_at};
}

void Visits::expire() {
  const auto now = parts_.clock.wall();
  const auto over = parts_.store.expired_visits(now);
  if (!over) return;
  for (const std::string& session : *over) {
    // Forgets a visit only after its session has ended, so that it is retried if Redis is
    // unavailable.
    if (parts_.placement.end(session)) (void)parts_.store.forget_visit(session);
  }
  (void)parts_.store.expire_links(now);
}

}  // namespace diaphane::api
