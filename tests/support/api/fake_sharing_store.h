#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "api/sharing/sharing_store.h"
#include "common/try.h"
#include "tests/support/api/fake.h"

namespace diaphane::api {

/// Permissions, links and visits in memory, for tests.
class FakeSharingStore final : public SharingStore, public Fake {
 public:
  struct Link {
    DataSetLink link;
    std::string data_set_id, token_hash;
  };
  std::map<std::string, SharedPerson> people_by_key;
  std::vector<Mail> invitations;
  std::vector<Link> all_links;
  std::map<std::string, std::pair<std::string, std::string>> keys;  ///< key to request hash and ID
  std::map<std::string, Visit> visits;                              ///< by session
  std::vector<DataSet> shown;                                       ///< what `gallery` returns
  GalleryQuery query;        ///< of the last call of `gallery`
  VisitLimits visit_limits;  ///< of the last call of `note_visit`
  int most_people = 0, most_links = 0;
  bool anonymised = true;
  std::optional<Permissions> published;         ///< empty while it is private
  std::map<std::string, std::string> accounts;  ///< user by address
  std::map<std::string, std::string> names;

  Result<std::vector<SharedPerson>> people(const std::string&) override {
    DIAPHANE_TRY(enter("people"));
    std::vector<SharedPerson> found;
    for (const auto& [key, person] : people_by_key) found.push_back(person);
    return found;
  }
  Result<Shared> share_with(const std::string& data_set_id, const SharedPerson& person, int most,
                            const Mail& mail) override {
    DIAPHANE_TRY(enter("share_with"));
    most_people = most;
    const auto known = people_by_key.find(person.email_key);
    if (known != people_by_key.end()) {
      return change_person(data_set_id, known->second.id,
                           {person.may_save, person.allowed.slices, person.allowed.downloads},
                           person.created_at);
    }
    people_by_key[person.email_key] = person;
    invitations.push_back(mail);
    return Shared{true, {}};
  }
  Result<Shared> change_person(const std::string&, const std::string& person_id,
                               const PersonChange& change, Time) override {
    DIAPHANE_TRY(enter("change_person"));
    for (auto& [key, person] : people_by_key) {
      if (person.id != person_id) continue;
      const Permissions before = person.allowed;
      person.may_save = change.may_save.value_or(person.may_save);
      person.allowed = {change.slices.value_or(before.slices),
                        change.downloads.value_or(before.downloads)};
      const bool narrowed = (before.slices && !person.allowed.slices) ||
                            (before.downloads && !person.allowed.downloads);
      return Shared{false, narrowed ? accounts[key] : ""};
    }
    return fail(ErrorCode::kNotFound, "no person");
  }
  Result<std::string> unshare(const std::string&, const std::string& person_id, Time) override {
    DIAPHANE_TRY(enter("unshare"));
    for (const auto& [key, person] : people_by_key) {
      if (person.id != person_id) continue;
      const std::string user_id = accounts[key];
      people_by_key.erase(key);
      return user_id;
    }
    return fail(ErrorCode::kNotFound, "no person");
  }

  Result<std::vector<DataSetLink>> links(const std::string& data_set_id, Time now) override {
    DIAPHANE_TRY(enter("links"));
    std::vector<DataSetLink> found;
    for (const Link& one : all_links) {
      if (one.data_set_id == data_set_id && one.link.expires_at > now) found.push_back(one.link);
    }
    return found;
  }
  Result<std::variant<DataSetLink, KeyReused>> make_link(
      const std::string& data_set_id, const DataSetLink& link, const std::string& token_hash,
      int most, const std::string& owner_id, const std::optional<IdempotencyKey>& key) override {
    DIAPHANE_TRY(enter("make_link"));
    most_links = most;
    const std::string whole_key = key ? owner_id + " " + key->key : "";
    if (key && keys.contains(whole_key)) {
      const auto& [hash, id] = keys[whole_key];
      if (hash != key->request_hash) return KeyReused{};
      for (const Link& one : all_links) {
        if (one.link.id == id && one.token_hash == token_hash) return one.link;
      }
      return fail(ErrorCode::kConflict, "ended, or of another browser");
    }
    if (key) keys[whole_key] = {key->request_hash, link.id};
    all_links.push_back({link, data_set_id, token_hash});
    return link;
  }
  Result<void> end_link(const std::string&, const std::string& link_id, Time) override {
    DIAPHANE_TRY(enter("end_link"));
    std::erase_if(visits, [&](const auto& one) { return one.second.link_id == link_id; });
    const auto gone =
        std::erase_if(all_links, [&](const Link& one) { return one.link.id == link_id; });
    if (gone == 0) return fail(ErrorCode::kNotFound, "no link");
    return {};
  }
  Result<Followed> follow(const std::string& token_hash, Time now) override {
    DIAPHANE_TRY(enter("follow"));
    for (const Link& one : all_links) {
      if (one.token_hash != token_hash || one.link.expires_at <= now) continue;
      Followed followed{one.link, {}};
      followed.data_set.id = one.data_set_id;
      return followed;
    }
    return fail(ErrorCode::kNotFound, "no link");
  }

  Result<bool> publish(const std::string&, const Permissions& allowed, Time) override {
    DIAPHANE_TRY(enter("publish"));
    if (anonymised) published = allowed;
    return anonymised;
  }
  Result<void> make_private(const std::string&, Time) override {
    DIAPHANE_TRY(enter("make_private"));
    published.reset();
    return {};
  }
  Result<std::vector<DataSet>> gallery(const Viewer&, const GalleryQuery& asked) override {
    DIAPHANE_TRY(enter("gallery"));
    query = asked;
    auto page = shown;
    if (static_cast<int>(page.size()) > asked.limit) page.resize(std::size_t(asked.limit));
    return page;
  }

  Result<std::string> public_name(const std::string& user_id) override {
    DIAPHANE_TRY(enter("public_name"));
    return names[user_id];
  }
  Result<void> set_public_name(const std::string& user_id, const std::string& name) override {
    DIAPHANE_TRY(enter("set_public_name"));
    names[user_id] = name;
    return {};
  }

  Result<Visit> note_visit(const Visit& visit, const VisitLimits& limits, Time) override {
    DIAPHANE_TRY(enter("note_visit"));
    visit_limits = limits;
    return visits.emplace(visit.session_id, visit).first->second;
  }
  Result<Visit> find_visit(const std::string& session_id, Time now) override {
    DIAPHANE_TRY(enter("find_visit"));
    const auto found = visits.find(session_id);
    if (found == visits.end() || found->second.expires_at <= now) {
      return fail(ErrorCode::kNotFound, "no visit");
    }
    return found->second;
  }
  Result<std::vector<std::string>> expired_visits(Time now) override {
    DIAPHANE_TRY(enter("expired_visits"));
    std::vector<std::string> found;
    for (const auto& [session, visit] : visits) {
      if (visit.expires_at <= now) found.push_back(session);
    }
    return found;
  }
  Result<void> forget_visit(const std::string& session_id) override {
    DIAPHANE_TRY(enter("forget_visit"));
    visits.erase(session_id);
    return {};
  }
  Result<void> expire_links(Time) override { return enter("expire_links"); }
};

}  // namespace diaphane::api
