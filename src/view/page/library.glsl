struct FurnaceLobe { uint family; uint masking; uint fresnel; float roughness; vec3 reflectance; vec3 eta; vec3 k; };
vec3 furnace_fresnel(FurnaceLobe l, float c) {
  if (l.fresnel == 0u) return vec3(1.0);
  if (l.fresnel == 3u) return l.eta + (1.0 - l.eta) * pow(1.0 - c, 5.0);
  vec3 g2 = l.eta*l.eta - 1.0 + c*c; 
  if (l.fresnel == 1u) { vec3 g = sqrt(max(g2, 0.0)); vec3 a=(g-c)/(g+c); vec3 b=(c*(g+c)-1.0)/(c*(g-c)+1.0); return 0.5*a*a*(1.0+b*b);}
  vec3 t = g2 - l.k*l.k + c*c*0.0; vec3 e2=l.eta*l.eta, k2=l.k*l.k; float s2=1.0-c*c;
  vec3 t0=e2-k2-s2; vec3 ab=sqrt(t0*t0+4.0*e2*k2); vec3 t1=ab+c*c; vec3 a=sqrt(0.5*(ab+t0)); vec3 t2=2.0*c*a; vec3 rs=(t1-t2)/(t1+t2);
  vec3 t3=c*c*ab+s2*s2; vec3 t4=t2*s2; return 0.5*rs*(1.0+(t3-t4)/(t3+t4));
}
vec3 furnace_f(FurnaceLobe l, vec3 o, vec3 i) {
  vec3 h = normalize(o+i); float d = dot(o,h); float c=h.z; float s2=dot(h.xy,h.xy);
  float D; float r=l.roughness; const float PI=3.14159265;
  if (l.family==0u) { float q=r/(r*r*c*c+s2); D=q*q/PI; }
  else if (l.family==1u) D=exp(-s2/(c*c*r*r))/(PI*r*r*c*c*c*c);
  else if (l.family==2u) D=r/(2.0*PI*(1.0-exp(-r)))*exp(-r*s2/(1.0+c))/c;
  else D=(r+2.0)/(2.0*PI)*exp(0.5*r*log(max(1.0-s2,1e-30)));
  float G;
  if (l.masking==1u) G=min(1.0,min(2.0*c*o.z/d,2.0*c*i.z/d));
  else { float a2=r*r; float lo=0.5*(sqrt(1.0+a2*(1.0/(o.z*o.z)-1.0))-1.0), li=0.5*(sqrt(1.0+a2*(1.0/(i.z*i.z)-1.0))-1.0); G=l.masking==2u?1.0/((1.0+lo)*(1.0+li)):1.0/(1.0+lo+li); }
  return l.reflectance*furnace_fresnel(l,d)*D*G/(4.0*o.z*i.z);
}
vec3 furnace_base(uint coupling, vec3 ks, vec3 kd, vec3 ro, vec3 ri, vec3 rm) {
  vec3 b = kd/3.14159265*(1.0-ks*ro)*(1.0-ks*ri);
  return coupling==1u ? b/max(1.0-ks*rm, 1e-6) : b;
}
vec3 furnace_kulla_conty(vec3 r0, float eo, float ei, float em) {
  vec3 fa = r0+(1.0-r0)/21.0; vec3 ms = fa*fa*em/(1.0-fa*(1.0-em));
  return ms*(1.0-eo)*(1.0-ei)/(3.14159265*(1.0-em));
}
vec3 furnace_turquin(vec3 r0, float eo) { return 1.0+r0*(1.0-eo)/eo; }
