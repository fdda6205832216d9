{{- define "diaphane.name" -}}
{{- if contains .Chart.Name .Release.Name }}{{ .Release.Name | trunc 40 | trimSuffix "-" }}{{ else }}{{ printf "%s-%s" .Release.Name .Chart.Name | trunc 40 | trimSuffix "-" }}{{ end -}}
{{- end -}}

{{- define "diaphane.image" -}}
{{- if .Values.image.digest }}{{ printf "%s@%s" .Values.image.repository .Values.image.digest }}{{ else }}{{ printf "%s:%s" .Values.image.repository (.Values.image.tag | default .Chart.AppVersion) }}{{ end -}}
{{- end -}}

{{/* The labels that select pods. They never change, and pods have no others, so that a new version of the chart alone replaces no pod. Call it with
     a list of the root and the component. */}}
{{- define "diaphane.selector" -}}
app.kubernetes.io/name: diaphane
app.kubernetes.io/instance: {{ (index . 0).Release.Name }}
app.kubernetes.io/component: {{ index . 1 }}
{{- end -}}

{{- define "diaphane.labels" -}}
{{ include "diaphane.selector" . }}
app.kubernetes.io/version: {{ (index . 0).Chart.AppVersion | quote }}
app.kubernetes.io/part-of: diaphane
app.kubernetes.io/managed-by: {{ (index . 0).Release.Service }}
helm.sh/chart: {{ printf "%s-%s" (index . 0).Chart.Name (index . 0).Chart.Version }}
{{- end -}}

{{- define "diaphane.host" -}}
{{ .Values.publicUrl | trimPrefix "https://" | trimPrefix "http://" }}
{{- end -}}

{{- define "diaphane.redis" -}}
{{ if .Values.trial.enabled }}{{ include "diaphane.name" . }}-trial-redis:6379{{ else }}{{ required "redis.address (host:port) is missing; to evaluate Diaphane without your own Redis, set trial.enabled" .Values.redis.address }}{{ end -}}
{{- end -}}

{{- define "diaphane.redisUrl" -}}
{{ if .Values.redis.tls }}rediss://{{ end }}{{ include "diaphane.redis" . }}
{{- end -}}

{{/* The prefix of the names of the secrets with certificates. Empty without TLS. */}}
{{- define "diaphane.innerTlsSecrets" -}}
{{- with .Values.innerTls -}}
{{- if .secretName }}{{ .secretName }}{{ else if .issuer.name }}{{ printf "%s-inner" (include "diaphane.name" $) }}{{ end -}}
{{- end -}}
{{- end -}}

{{/* The secret with the certificate of a program. Without roles, all programs share one secret. Call this and innerTlsMounts and innerTlsVolumes with
     a list of the root and the program. */}}
{{- define "diaphane.innerTlsSecret" -}}
{{- include "diaphane.innerTlsSecrets" (index . 0) }}{{ if (index . 0).Values.innerTls.roles }}-{{ index . 1 }}{{ end -}}
{{- end -}}

{{/* Environment variables for TLS to Diaphane's other programs and to Redis. Use them with innerTlsMounts and innerTlsVolumes. */}}
{{- define "diaphane.innerTls" -}}
{{- if include "diaphane.innerTlsSecrets" . }}
- {name: DIAPHANE_INNER_TLS_CA, value: /inner-tls/ca.crt}
- {name: DIAPHANE_INNER_TLS_CERTIFICATE, value: /inner-tls/tls.crt}
- {name: DIAPHANE_INNER_TLS_KEY, value: /inner-tls/tls.key}
- {name: DIAPHANE_INNER_TLS_NAME, value: {{ .Values.innerTls.serverName | quote }}}
{{- if not .Values.innerTls.roles }}
- {name: DIAPHANE_INNER_TLS_ROLES, value: "0"}
{{- end }}
{{- end }}
{{- if .Values.innerTls.plain }}
- {name: DIAPHANE_INNER_PLAIN, value: "1"}
{{- end }}
{{- end -}}

{{/* Mounts the whole directory, because Kubernetes does not update files that are mounted with subPath. */}}
{{- define "diaphane.innerTlsMounts" -}}
{{- if include "diaphane.innerTlsSecrets" (index . 0) }}
- {name: inner-tls-{{ index . 1 }}, mountPath: /inner-tls, readOnly: true}
{{- end }}
{{- end -}}

{{- define "diaphane.innerTlsVolumes" -}}
{{- if include "diaphane.innerTlsSecrets" (index . 0) }}
- name: inner-tls-{{ index . 1 }}
  secret:
    secretName: {{ include "diaphane.innerTlsSecret" . }}
    defaultMode: 0440
    items: [{key: ca.crt, path: ca.crt}, {key: tls.crt, path: tls.crt}, {key: tls.key, path: tls.key}]
{{- end }}
{{- end -}}

{{/* Environment variable that tells libpq the CA of the Postgres certificate. Use it with postgresCaMounts and postgresCaVolumes. */}}
{{- define "diaphane.postgresCa" -}}
{{- if .Values.postgres.caSecretName }}
- {name: PGSSLROOTCERT, value: /postgres-ca/ca.crt}
{{- end }}
{{- end -}}

{{- define "diaphane.postgresCaMounts" -}}
{{- if .Values.postgres.caSecretName }}
- {name: postgres-ca, mountPath: /postgres-ca, readOnly: true}
{{- end }}
{{- end -}}

{{- define "diaphane.postgresCaVolumes" -}}
{{- with .Values.postgres.caSecretName }}
- name: postgres-ca
  secret:
    secretName: {{ . }}
    defaultMode: 0440
    items: [{key: ca.crt, path: ca.crt}]
{{- end }}
{{- end -}}

{{- define "diaphane.redisPort" -}}
{{ include "diaphane.redis" . | splitList ":" | last }}
{{- end -}}

{{- define "diaphane.secret" -}}
{{ required "existingSecret is missing: set it to the name of a secret with the keys postgres, mail and factor-key (README.md)" .Values.existingSecret }}
{{- end -}}

{{- define "diaphane.claim" -}}
{{- $of := index (index . 0).Values.storage (index . 1) -}}
{{ $of.existingClaim | default (printf "%s-%s" (include "diaphane.name" (index . 0)) (index . 1)) }}
{{- end -}}

{{/* Meets the Pod Security standard "restricted". */}}
{{- define "diaphane.podSecurity" -}}
runAsNonRoot: true
runAsUser: 10001
runAsGroup: 10001
fsGroup: 10001
fsGroupChangePolicy: OnRootMismatch
seccompProfile: {type: RuntimeDefault}
{{- end -}}

{{- define "diaphane.containerSecurity" -}}
allowPrivilegeEscalation: false
readOnlyRootFilesystem: true
capabilities: {drop: [ALL]}
{{- end -}}

{{/* The parts of a pod spec that all components share. Call it with a list of the root and the values of the component. */}}
{{- define "diaphane.pod" -}}
{{- $root := index . 0 -}}{{- $part := index . 1 -}}
automountServiceAccountToken: false
enableServiceLinks: false
securityContext:
  {{- include "diaphane.podSecurity" $root | nindent 2 }}
{{- with $root.Values.image.pullSecrets }}
imagePullSecrets:
  {{- range . }}
  - name: {{ . }}
  {{- end }}
{{- end }}
{{- with $root.Values.priorityClassName }}
priorityClassName: {{ . }}
{{- end }}
{{- with $part.nodeSelector }}
nodeSelector: {{ toJson . }}
{{- end }}
{{- with $part.tolerations }}
tolerations: {{ toJson . }}
{{- end }}
{{- end -}}

{{/* Spreads the pods over nodes, and over zones if there are any. Zones use anti-affinity, because with a second spread constraint, the scheduler would
     ignore the first one on nodes without a zone. Call it with a list of the root and the component. */}}
{{- define "diaphane.spread" -}}
{{- $on := . -}}
topologySpreadConstraints:
  - maxSkew: 1
    topologyKey: kubernetes.io/hostname
    whenUnsatisfiable: ScheduleAnyway
    labelSelector:
      matchLabels:
        {{- include "diaphane.selector" $on | nindent 8 }}
affinity:
  podAntiAffinity:
    preferredDuringSchedulingIgnoredDuringExecution:
      - weight: 100
        podAffinityTerm:
          topologyKey: topology.kubernetes.io/zone
          labelSelector:
            matchLabels:
              {{- include "diaphane.selector" $on | nindent 14 }}
{{- end -}}

{{/* Probes of the admin port. /healthz ignores dependencies, so that an outage of Postgres or Redis restarts no pod. Call it with the name of the port. */}}
{{- define "diaphane.probes" -}}
startupProbe:
  httpGet: {path: /healthz, port: {{ . }}}
  periodSeconds: 2
  failureThreshold: 60
livenessProbe:
  httpGet: {path: /healthz, port: {{ . }}}
  periodSeconds: 10
  timeoutSeconds: 3
  failureThreshold: 3
readinessProbe:
  httpGet: {path: /readyz, port: {{ . }}}
  periodSeconds: 3
  timeoutSeconds: 2
  failureThreshold: 2
{{- end -}}

{{- define "diaphane.extraEnv" -}}
{{- range $name, $value := . }}
- name: {{ $name }}
  value: {{ $value | quote }}
{{- end }}
{{- end -}}

{{- define "diaphane.fromSecret" -}}
valueFrom: {secretKeyRef: {name: {{ include "diaphane.secret" (index . 0) }}, key: {{ index . 1 }}}}
{{- end -}}
