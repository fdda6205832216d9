#include "api/scans/uploads.h"

#include "tests/support/api/data_set_fixture.h"
#include "tests/support/api/temporary_directory.h"

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;

/// An upload of ten bytes, owned by `owner`. Four bytes have arrived.
class UploadsTest : public DataSetFixture {
 protected:
  UploadsTest() {
    upload() = {id, 10, 4, clock.wall() + 24h, DataSetState::kUploading};
    directory.write(file, "abcd");
    signals.subscribe(Signal::kDisposal, [this] { ++woken; });
  }
  Upload& upload() { return data_set_store.uploads[id]; }
  Refusal append(const std::string& offset, const std::string& bytes,
                 const std::string& checksum = "") {
    return refusal(uploads.append(owner, id, offset, checksum, bytes));
  }
  Refusal check(const std::string& offset, std::int64_t bytes, const std::string& checksum = "") {
    return refusal(uploads.check_part(owner, id, offset, checksum, bytes));
  }

  const TemporaryDirectory directory;
  const std::string file = id + ".tar";
  UploadFiles files{directory.path()};
  int woken = 0;
  Uploads uploads{data_set_store, files, clock, signals, 24h, 0};
};

TEST_F(UploadsTest, PartsAreWrittenWhereTheyBelong) {
  clock.advance(1h);
  const auto after = uploads.append(owner, id, "4", "", "efg");
  ASSERT_TRUE(after);
  EXPECT_EQ(after->received, 7);
  EXPECT_EQ(after->state, DataSetState::kUploading);
  EXPECT_EQ(after->expires_at, clock.wall() + 24h) << "each part starts the day again";
  EXPECT_EQ(upload().expires_at, after->expires_at);
  const auto complete = uploads.append(owner, id, "7", "", "hij");
  ASSERT_TRUE(complete);
  EXPECT_EQ(complete->received, 10);
  EXPECT_EQ(complete->state, DataSetState::kQueued);
  EXPECT_EQ(directory.read(file), "abcdefghij");
}

TEST_F(UploadsTest, OnlyTheFirstPartMakesTheFile) {
  upload().received = 0;
  ASSERT_TRUE(files.remove(id));
  EXPECT_EQ(append("0", "ab"), Refusal());
  ASSERT_TRUE(files.remove(id));
  EXPECT_EQ(append("2", "cd"), ProblemKind::kUnavailable);
  EXPECT_FALSE(directory.has(file));
}

TEST_F(UploadsTest, UploadsOfOthersAreNotFound) {
  EXPECT_EQ(uploads.find(owner, id)->received, 4);
  EXPECT_EQ(refusal(uploads.find(owner, "no id")), ProblemKind::kNotFound);
  EXPECT_EQ(refusal(uploads.find(owner, new_id())), ProblemKind::kNotFound);
  for (const Principal& who : {shared, stranger, administrator, Principal{}}) {
    EXPECT_EQ(refusal(uploads.find(who, id)), ProblemKind::kNotFound);
    EXPECT_EQ(refusal(uploads.check_part(who, id, "4", "", 1)), ProblemKind::kNotFound);
    EXPECT_EQ(refusal(uploads.append(who, id, "4", "", "e")), ProblemKind::kNotFound);
    EXPECT_EQ(refusal(uploads.terminate(who, id)), ProblemKind::kNotFound);
  }
  EXPECT_EQ(directory.read(file), "abcd");
}

TEST_F(UploadsTest, AnUploadExpiresADayAfterItsLastPart) {
  clock.advance(24h - 1s);
  EXPECT_EQ(check("4", 1), Refusal());
  clock.advance(1s);
  EXPECT_EQ(refusal(uploads.find(owner, id)), ProblemKind::kUploadExpired);
  EXPECT_EQ(check("4", 1), ProblemKind::kUploadExpired);
  EXPECT_EQ(append("4", "e"), ProblemKind::kUploadExpired);
  upload().state = DataSetState::kExpired;
  upload().expires_at = clock.wall() + 1h;
  EXPECT_EQ(refusal(uploads.find(owner, id)), ProblemKind::kUploadExpired);
  upload() = {id, 10, 10, clock.wall() - 1h, DataSetState::kBuilding};
  EXPECT_TRUE(uploads.find(owner, id)) << "a complete upload does not expire";
}

TEST_F(UploadsTest, APartIsCheckedBeforeAndWithItsBytes) {
  struct Case {
    std::string offset, bytes, checksum;
    ProblemKind expected;
  };
  for (const Case& one : {Case{"3", "d", "", ProblemKind::kOffsetMismatch},
                          Case{"5", "f", "", ProblemKind::kOffsetMismatch},
                          Case{"four", "e", "", ProblemKind::kInvalid},
                          Case{"4", "efghijk", "", ProblemKind::kInvalid},
                          Case{"4", "e", "md5 AAAA", ProblemKind::kInvalid}}) {
    const auto length = static_cast<std::int64_t>(one.bytes.size());
    EXPECT_EQ(check(one.offset, length, one.checksum), one.expected) << one.offset << one.bytes;
    EXPECT_EQ(append(one.offset, one.bytes, one.checksum), one.expected) << one.offset << one.bytes;
  }
  EXPECT_EQ(check("4", tus::kMaxPartBytes + 1), ProblemKind::kBodyTooLarge);
  EXPECT_EQ(directory.read(file), "abcd");
}

TEST_F(UploadsTest, CompleteUploadAcceptsOnlyAnEmptyPartAtItsEnd) {
  upload() = {id, 10, 10, clock.wall() + 1h, DataSetState::kQueued};
  EXPECT_EQ(append("10", ""), Refusal());
  EXPECT_EQ(append("4", "efghij"), ProblemKind::kUploadComplete);
  EXPECT_EQ(check("4", 6), ProblemKind::kUploadComplete);
  EXPECT_EQ(directory.read(file), "abcd");
  EXPECT_EQ(data_set_store.calls("advance_upload"), 0);
}

TEST_F(UploadsTest, ACorruptedPartIsDiscarded) {
  // SHA-1 of "hello" in Base64.
  const std::string checksum = "sha1 qvTGHdzF6KLavt4PO0gs2a6pQ00=";
  EXPECT_EQ(append("4", "hellp", checksum), ProblemKind::kChecksumMismatch);
  EXPECT_EQ(directory.read(file), "abcd");
  EXPECT_EQ(upload().received, 4);
  EXPECT_EQ(append("4", "hello", checksum), Refusal());
}

TEST_F(UploadsTest, KeepsTheDiskReserveDuringUploads) {
  Uploads reserved(data_set_store, files, clock, signals, 24h, std::int64_t{1} << 60);
  const auto refused = reserved.check_part(owner, id, "4", "", 1);
  ASSERT_EQ(refusal(refused), ProblemKind::kStorageFull);
  EXPECT_EQ(refused.error().retry_after, 1min);
  EXPECT_EQ(refusal(reserved.append(owner, id, "4", "", "e")), ProblemKind::kStorageFull);
  EXPECT_EQ(directory.read(file), "abcd");
}

TEST_F(UploadsTest, RefusesASecondConcurrentPart) {
  const auto other = files.open(id, false);
  ASSERT_TRUE(other);
  const auto refused = uploads.append(owner, id, "4", "", "e");
  ASSERT_EQ(refusal(refused), ProblemKind::kLocked);
  EXPECT_EQ(refused.error().retry_after, 1s);
}

TEST_F(UploadsTest, APartThatArrivedOnAnotherConnectionIsNotWrittenAgain) {
  data_set_store.before("find_upload", [&] {
    if (data_set_store.calls("find_upload") == 2) upload().received = 5;
  });
  EXPECT_EQ(append("4", "X"), ProblemKind::kOffsetMismatch);
  EXPECT_EQ(directory.read(file), "abcd");
}

TEST_F(UploadsTest, AFileOfAnUploadThatWasDeletedMeanwhileIsDeleted) {
  data_set_store.before("find_upload", [&] {
    if (data_set_store.calls("find_upload") == 2) data_set_store.uploads.erase(id);
  });
  EXPECT_EQ(append("4", "e"), ProblemKind::kNotFound);
  EXPECT_FALSE(directory.has(file));
}

TEST_F(UploadsTest, AFileOfAnUploadThatExpiredWhileAPartWasWrittenIsDeleted) {
  data_set_store.before("advance_upload", [&] { upload().state = DataSetState::kExpired; });
  EXPECT_EQ(append("4", "e"), ProblemKind::kUploadExpired);
  EXPECT_FALSE(directory.has(file));
}

TEST_F(UploadsTest, UploadAdvancedByAnotherPartKeepsItsFile) {
  data_set_store.before("advance_upload", [&] { upload().received = 6; });
  EXPECT_EQ(append("4", "e"), ProblemKind::kOffsetMismatch);
  EXPECT_TRUE(directory.has(file));
}

TEST_F(UploadsTest, DatabaseOutageDuringAPartLosesNoData) {
  for (const int failing : {1, 2}) {
    const int before = data_set_store.calls("find_upload");
    data_set_store.before("find_upload", [&] {
      if (data_set_store.calls("find_upload") == before + failing) {
        data_set_store.break_function("find_upload");
      }
    });
    EXPECT_EQ(append("4", "e"), ProblemKind::kUnavailable);
    EXPECT_EQ(directory.read(file), "abcd") << "the data that has arrived is kept";
    data_set_store.repair("find_upload");
  }
  data_set_store.before("find_upload", [] {});
  data_set_store.before("advance_upload", [&] {
    data_set_store.break_function("find_upload");
    data_set_store.break_function("advance_upload", ErrorCode::kConflict);
  });
  EXPECT_EQ(append("4", "e"), ProblemKind::kUnavailable);
  EXPECT_TRUE(directory.has(file));
  data_set_store.before("advance_upload", [] {});
  data_set_store.repair("find_upload");
  data_set_store.repair("advance_upload");
  EXPECT_EQ(append("4", "efghij"), Refusal());
  EXPECT_EQ(directory.read(file), "abcdefghij");
}

TEST_F(UploadsTest, AnUploadIsTerminatedOnlyBeforeItIsComplete) {
  upload().state = DataSetState::kQueued;
  EXPECT_EQ(refusal(uploads.terminate(owner, id)), ProblemKind::kUploadComplete);
  EXPECT_EQ(woken, 0);
  upload().state = DataSetState::kUploading;
  EXPECT_TRUE(uploads.terminate(owner, id));
  EXPECT_EQ(woken, 1) << "its file is queued for deletion";
  EXPECT_EQ(refusal(uploads.terminate(owner, id)), ProblemKind::kNotFound);
  EXPECT_EQ(refusal(uploads.terminate(owner, "no id")), ProblemKind::kNotFound);
}

TEST_F(UploadsTest, ReportsAnUnavailableStore) {
  expect_unavailable({
      {data_set_store, "find_upload", [&] { return refusal(uploads.find(owner, id)); }},
      {data_set_store, "find_upload", [&] { return check("4", 1); }},
      {data_set_store, "advance_upload", [&] { return append("4", "e"); }},
      {data_set_store, "cancel_upload", [&] { return refusal(uploads.terminate(owner, id)); }},
  });
  EXPECT_EQ(upload().received, 4);
}

}  // namespace
}  // namespace diaphane::api
