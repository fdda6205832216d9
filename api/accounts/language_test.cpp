// The language of emails: how it is read from a request, and what there is in each.
#include "api/accounts/language.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "api/accounts/account_mails.h"

namespace diaphane::api {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(PreferredLanguage, IsTheOneWithTheHighestQuality) {
  for (const char* german :
       {"de", "DE", "de-AT", "de-Latn-DE, en", "fr, de;q=0.2", "en;q=0.8, de;q=0.9",
        "en;q=0.899,de;q=0.9", " de ; q=0.5 ", "en;q=0, de;q=0.001", "de,en", "*, de;q=0.1",
        "en;q=.9, de;q=0.1", "en;q=1.001, de;q=0.1", "en;q=0.1x, de;q=0.1", "en;level=1, de"}) {
    EXPECT_EQ(preferred_language(german), Language::kGerman) << german;
  }
  for (const char* english :
       {"en", "en-GB, de", "en, de", "de;q=0.8, en;q=0.9", "de;q=0", "de;q=0.000", "fr", "*"}) {
    EXPECT_EQ(preferred_language(english), Language::kEnglish) << english;
  }
}

TEST(PreferredLanguage, IsEnglishForGarbage) {
  for (const std::string& garbage :
       {std::string(), std::string(";"), std::string(",,,;q=,"), std::string("den"),
        std::string("deutsch"), std::string("de_DE"), std::string("d"), std::string("-de"),
        std::string("de;q="), std::string("de;q=2"), std::string("de;q=1.0000"),
        std::string("de;q=0.1111"), std::string("de;q=-1"), std::string("de;q=0.5;q=0.5"),
        std::string("de\r\nBcc: a@b.c"), std::string("de\0", 3), std::string("\xff\xfe"),
        "de," + std::string(253, 'x')}) {
    EXPECT_EQ(preferred_language(garbage), Language::kEnglish) << garbage;
  }
}

const std::string kTo = "anna@example.org", kLink = "https://see.example/page#token=abc";

using WithLink = Mail (*)(Language, const std::string&, const std::string&);

TEST(Mails, ExistInBothLanguagesWithTheirLink) {
  for (const WithLink make :
       {mails::welcome, mails::already_there, mails::reset, mails::no_account,
        mails::account_disabled, mails::password_changed, mails::confirm_new_address,
        mails::new_address_taken, mails::address_change_requested, mails::second_factor_added,
        mails::second_factor_removed, mails::recovery_code_used, mails::code_reused,
        mails::recovery_codes_renewed}) {
    const Mail english = make(Language::kEnglish, kTo, kLink);
    const Mail german = make(Language::kGerman, kTo, kLink);
    for (const Mail& mail : {english, german}) {
      EXPECT_EQ(mail.recipient, kTo);
      EXPECT_THAT(mail.body, HasSubstr("\n\n" + kLink + "\n")) << mail.subject;
      EXPECT_TRUE(mail.body.ends_with(".\n") || mail.body.ends_with(kLink + "\n"));
    }
    EXPECT_NE(english.subject, german.subject);
    EXPECT_THAT(english.body, Not(HasSubstr("Sie ")));
    EXPECT_THAT(german.body, HasSubstr("Sie "));
    EXPECT_THAT(german.body, Not(HasSubstr("you")));
  }
  for (const auto make : {mails::address_changed, mails::account_deleted}) {
    EXPECT_THAT(make(Language::kEnglish, kTo).body, HasSubstr("Your Diaphane account"));
    EXPECT_THAT(make(Language::kGerman, kTo).body, HasSubstr("Ihr Konto bei Diaphane"));
  }
}

TEST(Mails, ToSomebodyElseAreInBothLanguagesAtOnce) {
  const Mail invitation = mails::invitation(kTo, "Bert", "bert@example.org", kLink);
  const std::size_t first = invitation.body.find(kLink);
  EXPECT_NE(invitation.body.find(kLink, first + 1), std::string::npos) << "once in each language";
  EXPECT_THAT(invitation.body, HasSubstr("Bert (bert@example.org) shared"));
  EXPECT_THAT(invitation.body, HasSubstr("Bert (bert@example.org) hat"));
  const std::string taken_off = mails::second_factor_taken_off(kTo).body;
  EXPECT_THAT(taken_off, HasSubstr("An administrator"));
  EXPECT_THAT(taken_off, HasSubstr("Die Administration"));
}

}  // namespace
}  // namespace diaphane::api
