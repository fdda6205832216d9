import type { ComponentChildren } from "preact";
import { t } from "../texts";
import { Mark } from "./icons";
import { PageTitle } from "./shell";

/**
 * The radii of slices of a head, in x and y, from the top down. The top ones are drawn last and are
 * the most opaque.
 */
const slices = [
  [9, 4],
  [17, 7.5],
  [23, 10],
  [27.5, 12],
  [31, 13.5],
  [33.5, 14.5],
  [35, 15.2],
  [35.5, 15.5],
  [35, 15.2],
  [33.5, 14.5],
  [31, 13.5],
  [28, 12.2],
  [26.5, 11.5],
  [25.5, 11],
  [24, 10.4],
  [21, 9.2],
  [18, 8],
] as const;

export function Art() {
  return (
    <svg class="art" viewBox="0 0 100 130" role="img" aria-label={t.account.art}>
      {[...slices].reverse().map(([rx, ry], i) => {
        const fromTop = slices.length - 1 - i;
        return (
          <g key={fromTop}>
            <ellipse
              cx="50"
              cy={18 + fromTop * 5.6}
              rx={rx}
              ry={ry}
              class="art-slice"
              fill-opacity={0.05 + 0.012 * i}
              stroke-opacity={0.25 + 0.04 * i}
            />
            {fromTop > 2 ? (
              <ellipse
                cx="50"
                cy={18 + fromTop * 5.6}
                rx={rx * 0.72}
                ry={ry * 0.7}
                class="art-core"
                stroke-opacity={0.12 + 0.03 * i}
              />
            ) : null}
          </g>
        );
      })}
    </svg>
  );
}

export interface AccountFrameProps {
  readonly title: string;
  readonly lead?: string;
  readonly children: ComponentChildren;
}

/** The frame of the pages for sign-up, confirmation and sign-in. */
export function AccountFrame({ title, lead, children }: AccountFrameProps) {
  return (
    <div class="account">
      <section class="account-form">
        <PageTitle text={title} />
        {lead ? <p class="lead">{lead}</p> : null}
        {children}
      </section>
      <aside class="account-art" aria-hidden="true">
        <Art />
        <p>
          <Mark />
          {t.tagline}
        </p>
      </aside>
    </div>
  );
}
