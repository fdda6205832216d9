/** The URL of each page, as plain data, so that tests can visit all pages. */

import { templates } from "../studies/definition";

export type Route =
  | {
      readonly page:
        | "home"
        | "scans"
        | "add"
        | "sign_in"
        | "sign_up"
        | "forgot"
        | "account"
        | "gallery"
        | "reports"
        | "not_found"
        /** A link whose secret is missing or was cut off. */
        | "incomplete_link";
    }
  | { readonly page: "admin"; readonly part: AdminPart }
  | { readonly page: "legal"; readonly legal: LegalPage }
  | { readonly page: "verify" | "join" | "shared" | "reset" | "confirm_email"; readonly token: string }
  | { readonly page: "view" | "sample" | "cut"; readonly dataSetId: string }
  | { readonly page: "compare"; readonly first: string; readonly second: string; readonly over: boolean }
  | { readonly page: "studies" }
  /** The composer. Before a study is saved for the first time, its ID is that of its template. */
  | { readonly page: "study" | "preview"; readonly studyId: string }
  /** The page of a participant. */
  | { readonly page: "take_part"; readonly token: string }
  | { readonly page: "withdraw"; readonly key: string };

export const adminParts = ["users", "audit", "fleet"] as const;
export type AdminPart = (typeof adminParts)[number];

/** The legal pages, whose texts the operator writes. Each name is the first segment of the page's path. */
export const legalPages = ["privacy", "terms", "contact"] as const;
export type LegalPage = (typeof legalPages)[number];

interface Rest {
  /** The further segments of the path, or empty. */
  readonly second: string;
  readonly third: string;
  readonly fourth: string;
  /** The fragment of the URL, which no server sees. */
  readonly hash: string;
}

const id = /^[0-9a-f-]{36}$/;
const secret = /^[0-9a-f]{64}$/;

/** The fragment of a link with which a participant deletes their answers begins with this. */
export const withdrawal = "withdraw:";

const tokenIn = (hash: string): string => new URLSearchParams(hash).get("token") ?? "";

/**
 * The routes by the first segment of the path. A function returns null if the rest of the URL is
 * invalid.
 */
const pages: Readonly<Record<string, (rest: Rest) => Route | null>> = {
  "": () => ({ page: "home" }),
  scans: () => ({ page: "scans" }),
  add: () => ({ page: "add" }),
  "sign-in": () => ({ page: "sign_in" }),
  "sign-up": () => ({ page: "sign_up" }),
  verify: ({ hash }) => ({ page: "verify", token: tokenIn(hash) }),
  forgot: () => ({ page: "forgot" }),
  reset: ({ hash }) => ({ page: "reset", token: tokenIn(hash) }),
  "confirm-email": ({ hash }) => ({ page: "confirm_email", token: tokenIn(hash) }),
  account: () => ({ page: "account" }),
  admin: ({ second }) => {
    const part = adminParts.find((one) => one === (second || "users"));
    return part ? { page: "admin", part } : null;
  },
  join: ({ hash }) => (secret.test(hash) ? { page: "join", token: hash } : { page: "incomplete_link" }),
  shared: ({ hash }) => (secret.test(hash) ? { page: "shared", token: hash } : { page: "incomplete_link" }),
  sample: ({ second }) => (id.test(second) ? { page: "sample", dataSetId: second } : null),
  gallery: () => ({ page: "gallery" }),
  privacy: () => ({ page: "legal", legal: "privacy" }),
  terms: () => ({ page: "legal", legal: "terms" }),
  contact: () => ({ page: "legal", legal: "contact" }),
  compare: ({ second, third, fourth }) =>
    id.test(second) && id.test(third) && (fourth === "" || fourth === "over")
      ? { page: "compare", first: second, second: third, over: fourth === "over" }
      : null,
  cut: ({ second }) => (id.test(second) ? { page: "cut", dataSetId: second } : null),
  reports: () => ({ page: "reports" }),
  studies: ({ second, hash }) => {
    if (second === "") return { page: "studies" };
    if (hash === "preview" && id.test(second)) return { page: "preview", studyId: second };
    return id.test(second) || (templates as readonly string[]).includes(second)
      ? { page: "study", studyId: second }
      : null;
  },
  study: ({ hash }) => {
    if (secret.test(hash)) return { page: "take_part", token: hash };
    const key = hash.startsWith(withdrawal) ? hash.slice(withdrawal.length) : "";
    return secret.test(key) ? { page: "withdraw", key } : { page: "incomplete_link" };
  },
  view: ({ second }) => (id.test(second) ? { page: "view", dataSetId: second } : null),
};

/** Returns the path of the page that shows two scans. */
export const comparePath = (first: string, second: string, over = false): string =>
  `/compare/${first}/${second}${over ? "/over" : ""}`;

/** The first path segments of all pages. */
export const firstWords: readonly string[] = Object.keys(pages);

/** Returns the route of a URL. `path` is its path, and `hash` its fragment with the #, or empty. */
export function routeOf(path: string, hash: string): Route {
  const [, first = "", second = "", third = "", fourth = ""] = path.split("/");
  const page = Object.hasOwn(pages, first) ? pages[first] : undefined;
  return page?.({ second, third, fourth, hash: hash.slice(1) }) ?? { page: "not_found" };
}
