import { useEffect } from "preact/hooks";
import { language, t } from "../texts";
import { SignIn, SignUp, Verify } from "./account";
import { Admin } from "./admin";
import { Add } from "./add";
import { CutPage } from "./cut/cut_page";
import { ConfirmEmail, Forgot, Reset } from "./forgot";
import { Gallery } from "./gallery";
import { Join } from "./join";
import { MyAccount } from "./my_account";
import { Link, navigate, route } from "./router";
import { Reports } from "./reports";
import { Scans } from "./scans";
import { SecondFactorFirst } from "./second_factor";
import { Notice, PageTitle, Shell } from "./shell";
import { SharedByLink, SharedSample } from "./shared";
import { AppContext, useApp, type AppState } from "./state";
import { OwnViewer } from "./viewer/viewer";

/** In another language every page begins anew: what it has shown was read from the texts before. Uploads and the account go on. */
export function App({ state }: { readonly state: AppState }) {
  return (
    <AppContext.Provider value={state}>
      <Page key={language.value} />
    </AppContext.Provider>
  );
}

function Page() {
  const app = useApp();
  const at = route.value;
  const me = app.me.value;

  if (at.page === "verify") return <Shell><Verify token={at.token} /></Shell>;
  if (at.page === "reset") return <Shell><Reset token={at.token} /></Shell>;
  if (at.page === "forgot") return <Shell><Forgot /></Shell>;
  if (at.page === "join") return <Join key={at.token} token={at.token} />;
  if (at.page === "shared") return <SharedByLink key={at.token} token={at.token} />;
  if (app.unreachable.value)
    return (
      <Shell>
        <div class="page page-narrow">
          <PageTitle text={t.name} />
          <Notice kind="bad">{t.problems.unreachable}</Notice>
          <p><button type="button" class="button" onClick={() => void app.load()}>{t.try_again}</button></p>
        </div>
      </Shell>
    );
  if (me === undefined) return <Shell><p class="page muted" role="status">{t.loading}</p></Shell>;
  if (at.page === "sign_up" && me === null) return <Shell><SignUp /></Shell>;
  if (at.page === "gallery") return <Shell><Gallery /></Shell>;
  if (at.page === "sample") return <SharedSample key={at.data_set_id} data_set_id={at.data_set_id} />;
  if (at.page === "not_found") return <Shell><NotFound /></Shell>;
  // Wherever one wanted to go: after signing in one is there.
  if (me === null) return <Shell><SignIn /></Shell>;
  switch (at.page) {
    case "confirm_email":
      return <Shell><ConfirmEmail token={at.token} /></Shell>;
    case "account":
      return <Shell><MyAccount me={me} /></Shell>;
    case "admin":
      return <Shell>{!me.administrator ? <NotFound /> : me.second_factor ? <Admin part={at.part} /> : <SecondFactorFirst />}</Shell>;
    case "add":
      return <Shell><Add /></Shell>;
    case "cut":
      return <CutPage key={at.data_set_id} data_set_id={at.data_set_id} />;
    case "view":
      return <OwnViewer key={at.data_set_id} data_set_id={at.data_set_id} />;
    case "reports":
      return <Shell><Reports /></Shell>;
    case "scans":
      return <Shell><Scans /></Shell>;
    default:
      return <Elsewhere />;
  }
}

function NotFound() {
  return <div class="page page-narrow"><PageTitle text={t.titles.not_found} /><p>{t.not_found}</p><p><Link href="/" class="button">{t.to_start}</Link></p></div>;
}

/** Signing up or in while signed in. */
function Elsewhere() {
  useEffect(() => navigate("/scans", true), []);
  return null;
}
