import { signal } from "@preact/signals";
import type { ComponentChildren } from "preact";

export type Route =
  | { readonly page: "scans" | "add" | "sign_in" | "sign_up" | "not_found" }
  | { readonly page: "verify" | "join"; readonly token: string }
  | { readonly page: "view"; readonly data_set_id: string };

export function route_of(path: string, hash: string): Route {
  const [, first = "", second = ""] = path.split("/");
  switch (first) {
    case "":
    case "scans":
      return { page: "scans" };
    case "add":
      return { page: "add" };
    case "sign-in":
      return { page: "sign_in" };
    case "sign-up":
      return { page: "sign_up" };
    case "verify":
      return { page: "verify", token: new URLSearchParams(hash.slice(1)).get("token") ?? "" };
    case "join":
      return /^#[0-9a-f]{64}$/.test(hash) ? { page: "join", token: hash.slice(1) } : { page: "not_found" };
    case "view":
      return /^[0-9a-f-]{36}$/.test(second) ? { page: "view", data_set_id: second } : { page: "not_found" };
    default:
      return { page: "not_found" };
  }
}

const here = () => route_of(location.pathname, location.hash);

export const route = signal<Route>(here());
addEventListener("hashchange", () => (route.value = here()));
addEventListener("popstate", () => (route.value = here()));

export function navigate(path: string, replace = false): void {
  if (replace) history.replaceState(null, "", path);
  else history.pushState(null, "", path);
  route.value = here();
  scrollTo(0, 0);
}

export interface LinkProps {
  readonly href: string;
  readonly class?: string;
  readonly label?: string;
  readonly current?: boolean;
  readonly children: ComponentChildren;
}

/** A link of the page itself: real for the browser (new tab, copy), without a reload for a plain click. */
export function Link(props: LinkProps) {
  return (
    <a
      href={props.href}
      {...(props.class ? { class: props.class } : {})}
      {...(props.label ? { "aria-label": props.label } : {})}
      {...(props.current ? { "aria-current": "page" as const } : {})}
      onClick={(event) => {
        if (event.button !== 0 || event.metaKey || event.ctrlKey || event.shiftKey || event.altKey) return;
        event.preventDefault();
        navigate(props.href);
      }}
    >
      {props.children}
    </a>
  );
}
