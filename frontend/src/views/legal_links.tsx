import { t } from "../texts";
import { Link, route } from "./router";
import { legalPages } from "./routes";

/** The links to the pages of the installation (legal.tsx), in the foot of every page. */
export function LegalLinks() {
  const at = route.value;
  return (
    <nav class="foot-links" aria-label={t.legal.nav}>
      {legalPages.map((page) => (
        <Link key={page} href={`/${page}`} current={at.page === "legal" && at.legal === page}>
          {t.legal.pages[page]}
        </Link>
      ))}
    </nav>
  );
}
