#include "api/http/reason_phrase.h"

#include <gtest/gtest.h>

#include "api/routing/problem_document.h"

namespace diaphane::api {
namespace {

TEST(ReasonPhrase, EachStatusHasItsStandardPhrase) {
  EXPECT_EQ(reason_phrase(200), "OK");
  EXPECT_EQ(reason_phrase(204), "No Content");
  EXPECT_EQ(reason_phrase(404), "Not Found");
  EXPECT_EQ(reason_phrase(428), "Precondition Required");
  EXPECT_EQ(reason_phrase(507), "Insufficient Storage");
}

TEST(ReasonPhrase, EveryProblemStatusHasASpecificPhrase) {
  for (int kind = 0; kind <= static_cast<int>(ProblemKind::kInternal); ++kind) {
    const int status = form_of(static_cast<ProblemKind>(kind)).status;
    EXPECT_NE(reason_phrase(status), "Client Error") << status;
    EXPECT_NE(reason_phrase(status), "Server Error") << status;
  }
}

TEST(ReasonPhrase, UnknownStatusFallsBackToItsClass) {
  EXPECT_EQ(reason_phrase(299), "Success");
  EXPECT_EQ(reason_phrase(499), "Client Error");
  EXPECT_EQ(reason_phrase(599), "Server Error");
}

}  // namespace
}  // namespace diaphane::api
