{{/* The nginx configuration of a single machine (api/edge/nginx.conf.in), with the ports and paths of a pod. */}}
{{- define "diaphane.edge" -}}
{{- $text := .Files.Get "files/nginx.conf.in" -}}
{{- if not $text }}{{ fail "files/nginx.conf.in is missing: package the chart from a checkout, where the file is a symbolic link" }}{{ end -}}
{{- $values := dict "LISTEN" "8080" "API_PORT" "8081" "STREAM_PORT" "8082" "STATIC_DIR" "/opt/diaphane/page" "RUN_DIR" "/run/edge"
      "CACHE_DIR" "/data/cache" "LEGAL_DIR" "/etc/legal" "PACS" (ternary (printf "%s-pacs:8096" (include "diaphane.name" .)) "127.0.0.1:8096" .Values.pacs.enabled) "ARCHIVES" (ternary "on" "off" .Values.pacs.enabled) "LOG" "/dev/stdout" "PUBLIC_HOST" (include "diaphane.host" .) -}}
{{- range $name, $value := $values }}{{ $text = $text | replace (printf "@%s@" $name) $value }}{{ end -}}
{{- with .Values.edge.trustedProxies -}}
{{- $real := "  real_ip_header X-Forwarded-For;\n  real_ip_recursive on;\n" -}}
{{- range . }}{{ $real = printf "%s  set_real_ip_from %s;\n" $real . }}{{ end -}}
{{- $text = $text | replace "\nhttp {\n" (printf "\nhttp {\n%s" $real) -}}
{{- end -}}
{{ $text }}
{{- end -}}
