#include "api/shared/signals.h"

#include <gtest/gtest.h>

namespace diaphane::api {
namespace {

TEST(Signals, ReachEachListenerOfTheSameSignalOnly) {
  Signals signals;
  int mailer = 0, log = 0, disposer = 0;
  signals.subscribe(Signal::kMail, [&] { ++mailer; });
  signals.subscribe(Signal::kMail, [&] { ++log; });
  signals.subscribe(Signal::kDisposal, [&] { ++disposer; });
  signals.raise(Signal::kMail);
  signals.raise(Signal::kMail);
  EXPECT_EQ(mailer, 2);
  EXPECT_EQ(log, 2);
  EXPECT_EQ(disposer, 0);
  signals.raise(Signal::kSignOut);  // without a listener
  signals.raise(Signal::kDisposal);
  EXPECT_EQ(disposer, 1);
}

TEST(Signals, ListenerMayRaiseAnotherSignal) {
  Signals signals;
  int mails = 0;
  signals.subscribe(Signal::kSignOut, [&] { signals.raise(Signal::kMail); });
  signals.subscribe(Signal::kMail, [&] { ++mails; });
  signals.raise(Signal::kSignOut);
  EXPECT_EQ(mails, 1);
}

}  // namespace
}  // namespace diaphane::api
