import { signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { routeOf, type Route } from "./routes";

const here = () => routeOf(location.pathname, location.hash);

export const route = signal<Route>(here());
addEventListener("hashchange", () => (route.value = here()));
addEventListener("popstate", () => (route.value = here()));

export function navigate(path: string, replace = false): void {
  if (replace) history.replaceState(history.state, "", path);
  else history.pushState({ from: location.pathname }, "", path);
  route.value = here();
  scrollTo(0, 0);
}

/**
 * Returns the path of the page whose link led here, also after a reload. Null if the user came from
 * another site or entered the address.
 */
export function cameFrom(): string | null {
  const state: unknown = history.state;
  return typeof state === "object" && state !== null && "from" in state && typeof state.from === "string"
    ? state.from
    : null;
}

export interface LinkProps {
  readonly href: string;
  readonly class?: string;
  readonly label?: string;
  readonly current?: boolean;
  readonly children: ComponentChildren;
}

/**
 * A link within the page. A plain click changes the page without a reload, and the browser handles
 * everything else, such as a new tab.
 */
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
