#include "api/environments/environments.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "common/ids.h"
#include "tests/support/api/fake_environment_store.h"
#include "tests/support/api/refusals.h"
#include "tests/support/api/temporary_directory.h"

namespace diaphane::api {
namespace {

class EnvironmentsTest : public testing::Test {
 protected:
  EnvironmentsTest() {
    anna.user_id = new_id();
    ben.user_id = new_id();
  }
  std::string file_of(const std::string& id) const { return "environments/" + id + ".hdr"; }

  Principal anna, ben;
  const Principal nobody;
  const TemporaryDirectory disk;
  const SystemClock clock;
  Signals signals;
  FakeEnvironmentStore store;
  FakeImporter importer;
  Environments environments{store, importer, clock, signals, disk.path()};
};

TEST_F(EnvironmentsTest, StoresOneFilePerContentAndAccount) {
  const auto first = environments.add(anna, "Forest", "file");
  ASSERT_TRUE(first);
  EXPECT_EQ(disk.read(file_of(first->id)), "file");
  const auto again = environments.add(anna, "Other name", "file");
  ASSERT_TRUE(again);
  EXPECT_EQ(again->id, first->id);
  EXPECT_EQ(again->name, "Forest");
  EXPECT_EQ(importer.calls("import"), 1);
  const auto of_ben = environments.add(ben, "Forest", "file");
  ASSERT_TRUE(of_ben);
  EXPECT_NE(of_ben->id, first->id) << "nobody learns what others have stored";
}

TEST_F(EnvironmentsTest, OnlyTheOwnerSeesTheNameAndChangesIt) {
  const auto added = environments.add(anna, "My garden", "file");
  ASSERT_TRUE(added);
  EXPECT_EQ(environments.list(anna)->size(), 1U);
  EXPECT_TRUE(environments.list(ben)->empty());
  EXPECT_EQ(environments.find(anna, added->id)->name, "My garden");
  for (const Principal& who : {ben, nobody}) {
    const auto found = environments.find(who, added->id);
    ASSERT_TRUE(found) << "the ID came with a scene";
    EXPECT_EQ(found->name, "");
    EXPECT_FALSE(found->mine);
  }
  EXPECT_EQ(refusal(environments.rename(ben, added->id, "Mine")), ProblemKind::kNotFound);
  EXPECT_EQ(refusal(environments.remove(ben, added->id)), ProblemKind::kNotFound);
  EXPECT_EQ(environments.rename(anna, added->id, "Park")->name, "Park");
  EXPECT_EQ(refusal(environments.find(anna, "../secret")), ProblemKind::kNotFound);
}

TEST_F(EnvironmentsTest, RemovingDeletesTheFileAndWakesTheDisposal) {
  int woken = 0;
  signals.subscribe(Signal::kDisposal, [&] { ++woken; });
  const auto added = environments.add(anna, "a", "file");
  ASSERT_TRUE(environments.remove(anna, added->id));
  EXPECT_EQ(woken, 1);
  EXPECT_FALSE(disk.has(file_of(added->id)));
  EXPECT_EQ(refusal(environments.find(anna, added->id)), ProblemKind::kNotFound);
  EXPECT_TRUE(environments.dispose(added->id)) << "may be repeated";
}

TEST_F(EnvironmentsTest, AnAccountHasALimitedNumber) {
  for (int i = 0; i < Environments::kMostEnvironments; ++i) {
    ASSERT_TRUE(environments.add(anna, "a", std::to_string(i)));
  }
  EXPECT_EQ(refusal(environments.add(anna, "a", "one more")), ProblemKind::kTooMany);
  EXPECT_EQ(importer.calls("import"), Environments::kMostEnvironments) << "it is not even read";
  EXPECT_TRUE(environments.add(ben, "a", "one more"));
  // Another request fills the last place during the import, so the database refuses.
  ASSERT_TRUE(environments.remove(anna, environments.list(anna)->front().id));
  importer.before("import", [&] {
    Environment other;
    other.owner_id = anna.user_id;
    store.environments.push_back(other);
  });
  const auto before =
      std::distance(std::filesystem::directory_iterator(disk.path() + "/environments"), {});
  EXPECT_EQ(refusal(environments.add(anna, "a", "late")), ProblemKind::kTooMany);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(disk.path() + "/environments"), {}),
            before)
      << "no file is left";
}

TEST_F(EnvironmentsTest, ImportsAreLimitedPerAccountAndInTotal) {
  const Principal carl{.user_id = new_id()};
  Refusal of_anna, of_carl;
  importer.before("import", [&] {
    if (importer.calls("import") == 1) {
      of_anna = refusal(environments.add(anna, "a", "second"));
      EXPECT_TRUE(environments.add(ben, "a", "of another account"));
    } else if (importer.calls("import") == 2) {
      of_carl = refusal(environments.add(carl, "a", "third"));
    }
  });
  ASSERT_TRUE(environments.add(anna, "a", "first"));
  EXPECT_EQ(of_anna, ProblemKind::kTooMany);
  EXPECT_EQ(of_carl, ProblemKind::kBusy);
  importer.before("import", [] {});
  EXPECT_TRUE(environments.add(carl, "a", "third")) << "the places are free again";
}

TEST_F(EnvironmentsTest, NamesWhatIsWrongWithAFile) {
  importer.break_function("import", ErrorCode::kInvalid, "shape");
  EXPECT_EQ(invalid_field(environments.add(anna, "a", "file")), "file.shape");
  importer.break_function("import", ErrorCode::kUnavailable);
  EXPECT_EQ(refusal(environments.add(anna, "a", "file")), ProblemKind::kUnavailable);
  EXPECT_TRUE(store.environments.empty());
}

TEST_F(EnvironmentsTest, KeepsTheFileIfItIsUnknownWhetherTheRowExists) {
  store.break_function("add", ErrorCode::kOutcomeUnknown);
  EXPECT_EQ(refusal(environments.add(anna, "a", "file")), ProblemKind::kOutcomeUnknown);
  EXPECT_NE(std::filesystem::directory_iterator(disk.path() + "/environments"),
            std::filesystem::directory_iterator());
}

}  // namespace
}  // namespace diaphane::api
