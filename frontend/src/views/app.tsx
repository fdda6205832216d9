import type { ComponentChildren, JSX } from "preact";
import { useEffect } from "preact/hooks";
import type { Me } from "../api/types";
import { language, t } from "../texts";
import { SignIn, SignUp, Verify } from "./account";
import { Admin } from "./admin";
import { Add } from "./add";
import { ComparePage } from "./compare/compare_page";
import { ConsentFirst } from "./consent";
import { CutPage } from "./cut/cut_page";
import { ConfirmEmail, Forgot, Reset } from "./forgot";
import { Gallery } from "./gallery";
import { Home } from "./home";
import { Join } from "./join";
import { Legal } from "./legal";
import { MyAccount } from "./my_account";
import { lazyPage } from "./lazy_page";
import { Loading } from "./loading";
import { Link, navigate, route } from "./router";
import type { AdminPart, Route } from "./routes";
import { Reports } from "./reports";
import { Scans } from "./scans";
import { SecondFactorFirst } from "./second_factor";
import { Notice, PageTitle, Shell } from "./shell";
import { SharedByLink, SharedSample } from "./shared";
import { AppContext, useApp, type AppState } from "./state";
import { OwnViewer } from "./viewer/viewer";

const PreviewStudy = lazyPage(async () => (await import("./studies/preview")).PreviewStudy);
const Studies = lazyPage(async () => (await import("./studies/studies")).Studies);
const StudyPage = lazyPage(async () => (await import("./studies/study_page")).StudyPage);
const TakePartByLink = lazyPage(async () => (await import("./studies/take_part")).TakePartByLink);
const Withdraw = lazyPage(async () => (await import("./studies/withdraw")).Withdraw);

/** A change of the language mounts the page again, because it contains the old texts. Uploads and the account stay. */
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
  const linked = linkedPage(at);
  if (linked) return linked;
  if (app.unreachable.value) return framed(<Unreachable />);
  if (me === undefined) return framed(<Loading page />);
  // After signing in, users reach the page that they requested.
  return openPage(at, me) ?? (me === null ? framed(<SignIn />) : accountPage(at, me));
}

const framed = (content: ComponentChildren): JSX.Element => <Shell>{content}</Shell>;

/**
 * Returns a page that does not depend on who is signed in: that of a mailed or shared link, or of
 * the installation.
 */
function linkedPage(at: Route): JSX.Element | null {
  switch (at.page) {
    case "verify":
      return framed(<Verify token={at.token} />);
    case "reset":
      return framed(<Reset token={at.token} />);
    case "forgot":
      return framed(<Forgot />);
    case "legal":
      return framed(<Legal key={at.legal} page={at.legal} />);
    case "join":
      return <Join key={at.token} token={at.token} />;
    case "shared":
      return <SharedByLink key={at.token} token={at.token} />;
    case "take_part":
      return <TakePartByLink key={at.token} token={at.token} />;
    case "withdraw":
      return <Withdraw key={at.key} participant={at.key} />;
    default:
      return null;
  }
}

/** Returns a page that needs no account. */
function openPage(at: Route, me: Me | null): JSX.Element | null {
  switch (at.page) {
    case "sign_up":
      return me === null ? framed(<SignUp />) : null;
    case "home":
      return me === null ? framed(<Home />) : null;
    case "gallery":
      return framed(<Gallery />);
    case "sample":
      return <SharedSample key={at.dataSetId} dataSetId={at.dataSetId} />;
    case "not_found":
      return framed(<NotFound />);
    case "incomplete_link":
      return framed(<NotFound title={t.titles.incompleteLink} text={t.incompleteLink} />);
    default:
      return null;
  }
}

function accountPage(at: Route, me: Me): JSX.Element {
  switch (at.page) {
    // Without a consent, people can still sign out, and download or delete their data.
    case "confirm_email":
      return framed(<ConfirmEmail token={at.token} />);
    case "account":
      return framed(<MyAccount me={me} />);
    default:
      return me.consent.given_at === null ? framed(<ConsentFirst version={me.consent.version} />) : scanPage(at, me);
  }
}

function scanPage(at: Route, me: Me): JSX.Element {
  switch (at.page) {
    case "admin":
      return framed(<AdminPage me={me} part={at.part} />);
    case "add":
      return framed(<Add />);
    case "cut":
      return <CutPage key={at.dataSetId} dataSetId={at.dataSetId} />;
    case "view":
      return <OwnViewer key={at.dataSetId} dataSetId={at.dataSetId} />;
    case "compare":
      return <ComparePage key={`${at.first} ${at.second} ${at.over}`} {...at} />;
    case "reports":
      return framed(<Reports />);
    case "scans":
      return framed(<Scans />);
    case "studies":
    case "study":
    case "preview":
      return studyPage(at, me);
    default:
      return <Elsewhere />;
  }
}

function studyPage(at: Extract<Route, { page: "studies" | "study" | "preview" }>, me: Me): JSX.Element {
  if (!me.researcher || at.page === "studies") return framed(<Studies researcher={me.researcher} />);
  if (at.page === "preview") return <PreviewStudy key={at.studyId} studyId={at.studyId} />;
  return framed(<StudyPage studyId={at.studyId} />);
}

function AdminPage({ me, part }: { readonly me: Me; readonly part: AdminPart }) {
  if (!me.administrator) return <NotFound />;
  return me.second_factor ? <Admin part={part} /> : <SecondFactorFirst />;
}

function Unreachable() {
  const app = useApp();
  return (
    <div class="page page-narrow">
      <PageTitle text={t.name} />
      <Notice kind="bad">{t.problems.unreachable}</Notice>
      <p>
        <button type="button" class="button" onClick={() => void app.load()}>
          {t.tryAgain}
        </button>
      </p>
    </div>
  );
}

function NotFound({ title = t.titles.notFound, text = t.notFound }: { title?: string; text?: string }) {
  return (
    <div class="page page-narrow">
      <PageTitle text={title} />
      <p>{text}</p>
      <p>
        <Link href="/" class="button">
          {t.toStart}
        </Link>
      </p>
    </div>
  );
}

/** Leads users away from the sign-up and sign-in forms, because they are already signed in. */
function Elsewhere() {
  useEffect(() => navigate("/scans", true), []);
  return null;
}
