#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "api/scans/data_set_store.h"
#include "common/try.h"
#include "tests/support/api/fake.h"

namespace diaphane::api {

/// Data sets in memory, for tests. Unlike the database, it also finds data sets that the viewer
/// must not know of, so that tests see what the services check themselves.
class FakeDataSetStore final : public DataSetStore, public Fake {
 public:
  std::map<std::string, DataSet> data_sets;                         ///< by ID, without roles
  std::map<std::pair<std::string, std::string>, Role> roles;        ///< by user and data set
  std::map<std::string, Upload> uploads;                            ///< by ID
  std::map<std::string, std::pair<std::string, std::string>> keys;  ///< key to request hash and ID
  std::vector<DataSet> listed;                                      ///< what `list` returns
  std::vector<std::pair<NewDataSet, Time>> created;
  std::vector<std::string> removed;
  std::vector<Disposal> due;
  std::vector<AuditEntry> accesses;
  std::vector<View> noted_views;
  std::vector<ViewEntry> view_log;   ///< what `views` returns
  ViewQuery view_query;              ///< of the last call of `views`
  std::optional<Creation> creation;  ///< what `create` returns instead of creating it
  DataSetLimits limits;              ///< passed by the last call of `create`

  Result<Creation> create(const NewDataSet& wanted, const DataSetLimits& most,
                          const std::optional<IdempotencyKey>& key, Time now) override {
    DIAPHANE_TRY(enter("create"));
    limits = most;
    if (creation) return *creation;
    if (key && keys.contains(key->key)) {
      const auto& [hash, id] = keys[key->key];
      if (hash != key->request_hash) return KeyReused{};
      return Created{id, true};
    }
    created.emplace_back(wanted, now);
    DataSet& made = data_sets[wanted.id];
    made.id = wanted.id;
    made.title = wanted.title;
    roles[{wanted.owner.user_id, wanted.id}] = Role::kOwner;
    if (key) keys[key->key] = {key->request_hash, wanted.id};
    return Created{wanted.id};
  }
  Result<std::vector<DataSet>> list(const Viewer&, std::optional<Cursor>, int limit) override {
    DIAPHANE_TRY(enter("list"));
    auto page = listed;
    if (static_cast<int>(page.size()) > limit) page.resize(static_cast<std::size_t>(limit));
    return page;
  }
  Result<DataSet> find(const Viewer& viewer, const std::string& id) override {
    DIAPHANE_TRY(enter("find"));
    const auto found = data_sets.find(id);
    if (found == data_sets.end()) return fail(ErrorCode::kNotFound, "no data set");
    DataSet data_set = found->second;
    const auto role = roles.find({viewer.user_id, id});
    const Role stranger = viewer.user_id.empty() ? Role::kNobody : Role::kOther;
    data_set.role = role == roles.end() ? stranger : role->second;
    return data_set;
  }
  Result<void> describe(const std::string& id, const Description& what, Time now) override {
    DIAPHANE_TRY(enter("describe"));
    DataSet& data_set = data_sets.at(id);
    data_set.title = what.title.value_or(data_set.title);
    data_set.updated_at = now;
    return {};
  }
  Result<void> remove(const Owner& owner, const std::string& id, Time) override {
    DIAPHANE_TRY(enter("remove"));
    removed.push_back(owner.user_id + " " + id);
    data_sets.erase(id);
    return {};
  }

  Result<Upload> find_upload(const Owner& owner, const std::string& id) override {
    DIAPHANE_TRY(enter("find_upload"));
    const auto found = uploads.find(id);
    if (found == uploads.end() || roles[{owner.user_id, id}] != Role::kOwner) {
      return fail(ErrorCode::kNotFound, "no upload");
    }
    return found->second;
  }
  Result<void> advance_upload(const std::string& id, std::int64_t from, std::int64_t to,
                              Time expires_at, Time) override {
    DIAPHANE_TRY(enter("advance_upload"));
    Upload& upload = uploads[id];
    if (upload.received != from || upload.state != DataSetState::kUploading) {
      return fail(ErrorCode::kConflict, "it has moved on");
    }
    upload.received = to;
    upload.expires_at = expires_at;
    if (to == upload.length) upload.state = DataSetState::kQueued;
    return {};
  }
  Result<void> cancel_upload(const Owner& owner, const std::string& id, Time now) override {
    DIAPHANE_TRY(enter("cancel_upload"));
    const auto upload = find_upload(owner, id);
    DIAPHANE_TRY(upload);
    if (upload->state != DataSetState::kUploading) return fail(ErrorCode::kConflict, "it is done");
    uploads.erase(id);
    return remove(owner, id, now);
  }
  Result<int> expire_uploads(Time) override { return 0; }

  Result<void> note_access(const AuditEntry& entry, Time, Time) override {
    DIAPHANE_TRY(enter("note_access"));
    accesses.push_back(entry);
    return {};
  }

  Result<void> note_view(const View& view, const AuditEntry& entry, Time) override {
    DIAPHANE_TRY(enter("note_view"));
    noted_views.push_back(view);
    accesses.push_back(entry);
    return {};
  }
  Result<std::vector<ViewEntry>> views(const std::string&, const ViewQuery& query) override {
    DIAPHANE_TRY(enter("views"));
    view_query = query;
    auto page = view_log;
    if (static_cast<int>(page.size()) > query.limit) page.resize(std::size_t(query.limit));
    return page;
  }
  Result<void> expire_views(Time) override { return enter("expire_views"); }

  Result<std::vector<Disposal>> disposals(int) override {
    DIAPHANE_TRY(enter("disposals"));
    return due;
  }
  Result<void> disposed(const Disposal& disposal) override {
    DIAPHANE_TRY(enter("disposed"));
    std::erase_if(due, [&](const Disposal& one) {
      return one.id == disposal.id && one.kind == disposal.kind;
    });
    return {};
  }
};

}  // namespace diaphane::api
