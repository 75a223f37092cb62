"""Stored chains and ArviZ's numbers for them."""
import numpy as np, arviz as az, json, warnings
from arviz.stats.diagnostics import _rhat_rank,_ess_bulk,_ess_tail,_ess_mean,_ess_quantile,_mcse_mean,_mcse_sd,_mcse_quantile
warnings.filterwarnings("ignore")
r=np.random.default_rng(20260101)
C,N=4,151
def ar(phi,shift=(0,0,0,0)):
    x=np.empty((C,N))
    for c in range(C):
        z=r.standard_normal()
        for i in range(N):
            z=phi*z+np.sqrt(1-phi*phi)*r.standard_normal(); x[c,i]=z+shift[c]
    return x
series={"white":ar(0.0),"sticky":ar(0.9),"shifted":ar(0.5,(0,0,0,1.0)),"antithetic":ar(-0.6),
 "cauchy":r.standard_cauchy((C,N)),"ties":np.round(ar(0.7)*2)/2}
series={k:np.array([[float(f"{v:.9g}") for v in row] for row in x]) for k,x in series.items()}
with open("chains.csv","w") as f:
    f.write("chain,"+",".join(series)+"\n")
    for c in range(C):
        for i in range(N): f.write(f"{c},"+",".join(repr(float(x[c,i])) for x in series.values())+"\n")
out={}
for k,x in series.items():
    out[k]=dict(r_hat=_rhat_rank(x),ess_bulk=_ess_bulk(x),ess_tail=_ess_tail(x),ess_mean=_ess_mean(x),ess_q30=_ess_quantile(x,.3),
      mcse_mean=_mcse_mean(x),mcse_sd=_mcse_sd(x),mcse_q05=_mcse_quantile(x,.05),mcse_q50=_mcse_quantile(x,.5),mcse_q95=_mcse_quantile(x,.95))
    out[k]={a:float(b) for a,b in out[k].items()}
json.dump(out,open("diagnostics.json","w"),indent=1)
# psis: log weights with light, heavy and very heavy tails, and a likelihood matrix
S=400
lw=np.stack([r.standard_normal(S)*.5, r.standard_normal(S)*2, -np.log(r.uniform(size=S))*0.9, -np.log(r.uniform(size=S))*1.6])
lw=np.vectorize(lambda v: float(f"{v:.9g}"))(lw)
pw={}
for reff in (1.0,0.4):
    o,k=az.psislw(lw.copy(),reff); pw[str(reff)]=dict(pareto_k=[float(v) for v in k], log_weights=o.tolist())
# loo: normal readings with inferred mean and sd; draws given
y=r.standard_normal(12)*1.3+.4; y[-1]=6.0
mu=y.mean()+r.standard_normal((4,100))*.4; sd=np.exp(np.log(y.std())+r.standard_normal((4,100))*.2)
ll=-0.5*((y[None,None]-mu[...,None])/sd[...,None])**2-np.log(sd[...,None])-.5*np.log(2*np.pi)
ll=np.vectorize(lambda v: float(f"{v:.9g}"))(ll)
d=az.from_dict(posterior={"mu":mu},log_likelihood={"y":ll})
l=az.loo(d,pointwise=True,reff=0.8)
pw["loo"]=dict(reff=0.8,elpd=float(l.elpd_loo),se=float(l.se),p_loo=float(l.p_loo),pointwise=l.loo_i.values.tolist(),pareto_k=l.pareto_k.values.tolist())
with open("log_weights.csv","w") as f:
    for i in range(S): f.write(",".join(repr(float(v)) for v in lw[:,i])+"\n")
with open("log_likelihoods.csv","w") as f:
    for row in ll.reshape(-1,12): f.write(",".join(repr(float(v)) for v in row)+"\n")
json.dump(pw,open("psis.json","w"),indent=1)
print(out, pw["loo"])
